// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <string_view>

#include <nlohmann/json.hpp>

#include "scene_io_parts.hpp"

namespace crease {
namespace {

/// Lists and objects within each other; a scene needs seven. Deeper ones cost a pointer each while they are read, hence
/// memory that grows with the square, and stack when they are printed.
constexpr int most_levels = 100;
const std::string too_many_levels =
    "must have at most " + std::to_string(most_levels) + " lists and objects within each other";

// Builds the document while it knows where it is, which nlohmann's own reader does not tell.
class DocumentBuilder : public nlohmann::json_sax<Json> {
 public:
  struct Failure {
    size_t position;      // bytes read when it was noticed
    std::string message;  // nlohmann's words
  };

  bool null() override { return put(nullptr); }
  bool boolean(bool value) override { return put(value); }
  bool number_integer(number_integer_t value) override { return put(value); }
  bool number_unsigned(number_unsigned_t value) override { return put(value); }
  bool number_float(number_float_t value, const string_t&) override { return put(value); }
  bool string(string_t& value) override { return put(value); }
  bool binary(binary_t&) override { return false; }
  bool start_object(std::size_t) override { return open(Json::object()); }
  bool start_array(std::size_t) override { return open(Json::array()); }
  bool end_object() override { return close(); }
  bool end_array() override { return close(); }
  bool key(string_t& name) override {
    key_ = name;
    if (stack_.back()->contains(name)) twice_.push_back(here());
    return true;
  }
  bool parse_error(std::size_t position, const std::string&, const nlohmann::detail::exception& error) override {
    failure_ = Failure{position, error.what()};
    return false;
  }

  Json& document() { return document_; }
  const std::optional<Failure>& failure() const { return failure_; }
  const std::vector<std::string>& keys_given_twice() const { return twice_; }
  bool too_deep() const { return stack_.size() >= most_levels; }  // for another

  /// Pointer of the value that is being read.
  std::string here() const {
    if (stack_.empty()) return "";
    return child_pointer(pointers_.back(), stack_.back()->is_object() ? key_ : std::to_string(stack_.back()->size()));
  }

 private:
  Json* place(Json value) {
    if (stack_.empty()) return &(document_ = std::move(value));
    if (stack_.back()->is_object()) return &((*stack_.back())[key_] = std::move(value));
    stack_.back()->push_back(std::move(value));
    return &stack_.back()->back();
  }
  bool put(Json value) {
    place(std::move(value));
    return true;
  }
  bool open(Json value) {
    if (too_deep()) return false;
    pointers_.push_back(here());
    stack_.push_back(place(std::move(value)));
    return true;
  }
  bool close() {
    stack_.pop_back();
    pointers_.pop_back();
    return true;
  }

  Json document_;
  std::vector<Json*> stack_;           // open containers; an open one is the last entry of the one before, so it stays
  std::vector<std::string> pointers_;  // of the open containers
  std::string key_;
  std::vector<std::string> twice_;
  std::optional<Failure> failure_;
};

std::string line_and_column(const std::string& text, size_t offset) {
  const auto begin = text.begin(), end = begin + static_cast<std::ptrdiff_t>(std::min(offset, text.size()));
  const auto line = 1 + std::count(begin, end, '\n');
  const size_t newline = offset == 0 ? std::string::npos : text.rfind('\n', offset - 1);
  const size_t column = newline == std::string::npos ? offset + 1 : offset - newline;
  return "line " + std::to_string(line) + ", column " + std::to_string(column);
}

struct Token {
  size_t begin, end;
};

// The word around the byte before `position`.
Token token_at(const std::string& text, size_t position) {
  const auto inside = [&](size_t i) {
    const auto c = static_cast<unsigned char>(text[i]);
    return std::isalnum(c) || c == '+' || c == '-' || c == '.';
  };
  Token token{std::min(position, text.size()), std::min(position, text.size())};
  while (token.begin > 0 && inside(token.begin - 1)) --token.begin;
  while (token.end < text.size() && inside(token.end)) ++token.end;
  return token;
}

bool is_not_finite(std::string_view word) {
  if (word.starts_with('-') || word.starts_with('+')) word.remove_prefix(1);
  if (word.empty()) return false;
  std::string lower;
  for (const char c : word) lower += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  if (lower == "nan" || lower == "inf" || lower == "infinity") return true;
  const bool digits = lower.find_first_not_of("0123456789.e+-") == std::string::npos;
  return digits && lower.find_first_of("0123456789") != std::string::npos &&
         !std::isfinite(std::strtod(lower.c_str(), nullptr));
}

// nlohmann: "[json.exception...] parse error at line L, column C: syntax error while parsing X - reason; last read:
// ..."
std::string reason(const std::string& message) {
  const size_t at = message.find(": syntax error ");
  return at == std::string::npos ? message.substr(message.find("] ") + 2) : message.substr(at + 2);
}

}  // namespace

std::optional<Json> parse_scene_text(const std::string& original, ProblemList& problems) {
  std::string text = original;
  // Every pass replaces one number that is not finite, so that the next one sees what comes behind it.
  constexpr int most_replacements = 100;
  for (int pass = 0; pass <= most_replacements; ++pass) {
    DocumentBuilder builder;
    const bool complete = Json::sax_parse(text, &builder, nlohmann::detail::input_format_t::json, true, true);
    if (complete) {
      for (const std::string& pointer : builder.keys_given_twice()) problems.add(pointer, "the key is given twice");
      return std::move(builder.document());
    }
    if (builder.too_deep() && !builder.failure()) {
      problems.add("", too_many_levels);
      return std::nullopt;
    }
    const size_t position = builder.failure() ? builder.failure()->position : 0;
    const Token token = token_at(text, position);
    const std::string word = text.substr(token.begin, token.end - token.begin);
    const size_t behind = text.find_first_not_of(" \t\r\n", token.end);
    const bool is_key = behind != std::string::npos && text[behind] == ':';
    if (is_key || !is_not_finite(word)) {
      problems.add("", line_and_column(text, position > 0 ? position - 1 : 0) + ": " +
                           (builder.failure() ? reason(builder.failure()->message) : "not JSON"));
      return std::nullopt;
    }
    problems.add(builder.here(),
                 "must be a finite number, got " + word + " (" + line_and_column(text, token.begin) + ")");
    text.replace(token.begin, word.size(), std::string(word.size(), ' ').replace(0, 1, "0"));
  }
  return std::nullopt;
}

void apply_override(Json& document, const std::string& path, const std::string& text, ProblemList& problems) {
  const std::string what = "--set " + path + ": ";
  if (std::count(path.begin(), path.end(), '.') >= most_levels) return problems.add("", "--set: " + too_many_levels);
  Json* target = &document;
  std::string pointer;
  for (size_t begin = 0; begin <= path.size();) {
    const size_t end = std::min(path.find('.', begin), path.size());
    const std::string key = path.substr(begin, end - begin);
    begin = end + 1;
    const bool digits = !key.empty() && key.size() < 10 && key.find_first_not_of("0123456789") == std::string::npos;
    if (target->is_null()) *target = digits ? Json::array() : Json::object();
    if (target->is_object() && !key.empty()) {
      target = &(*target)[key];
    } else if (target->is_array()) {
      const size_t index = digits ? std::stoul(key) : target->size() + 1;
      if (index > target->size())
        return problems.add(pointer, what + "\"" + key + "\" is no entry of this list; it has " +
                                         std::to_string(target->size()) +
                                         ", counted from 0, and the next can be added");
      if (index == target->size()) target->push_back(nullptr);
      target = &(*target)[index];
    } else {
      return problems.add(pointer, what +
                                       "nothing can be set below a plain value; write a dotted path such as "
                                       "contact.threshold");
    }
    pointer = child_pointer(pointer, key);
  }
  bool too_deep = false;
  const auto shallow = [&](int depth, Json::parse_event_t, const Json&) {
    too_deep = too_deep || depth > most_levels;
    return !too_deep;  // false drops what comes, so that it never nests
  };
  Json value = Json::parse(text, shallow, false);
  if (too_deep) return problems.add(pointer, what + too_many_levels);
  if (value.is_discarded() && is_not_finite(text))
    return problems.add(pointer, what + "must be a finite number, got " + text);
  *target = value.is_discarded() ? Json(text) : std::move(value);
}

void fill_dependent_defaults(Json& document) {
  const auto name_all = [&](const char* list, const std::string& name) {
    if (!document.is_object() || !document.contains(list) || !document[list].is_array()) return;
    Json& items = document[list];
    const auto is_taken = [&](const std::string& wanted) {
      return std::any_of(items.begin(), items.end(), [&](const Json& item) {
        return item.is_object() && item.contains("name") && item["name"] == wanted;
      });
    };
    for (size_t i = 0; i < items.size(); ++i) {
      if (!items[i].is_object() || items[i].contains("name")) continue;
      std::string free = items.size() == 1 ? name : name + std::to_string(i);
      for (size_t number = items.size(); is_taken(free); ++number) free = name + std::to_string(number);
      items[i]["name"] = free;
    }
  };
  name_all("cloths", "cloth");
  name_all("obstacles", "obstacle");
  if (!document.is_object() || !document.contains("cloths") || !document["cloths"].is_array()) return;
  for (Json& cloth : document["cloths"])
    if (cloth.is_object() && cloth.contains("shape") && cloth["shape"].is_object() && cloth["shape"].contains("grid") &&
        !cloth.contains("placement"))
      cloth["placement"] = Json::object();
}

}  // namespace crease
