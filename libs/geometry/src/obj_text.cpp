// SPDX-License-Identifier: MIT
#include "obj_text.hpp"

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <fstream>
#include <stdexcept>
#include <string_view>

namespace crease {
namespace {

std::vector<std::string_view> split_words(std::string_view line) {
  std::vector<std::string_view> words;
  constexpr std::string_view blank = " \t\r\n";
  for (size_t begin = line.find_first_not_of(blank); begin != std::string_view::npos;) {
    const size_t end = std::min(line.find_first_of(blank, begin), line.size());
    words.push_back(line.substr(begin, end - begin));
    begin = line.find_first_not_of(blank, end);
  }
  return words;
}

// std::from_chars and not a stream: the same in every locale, and nothing is left over unseen.
template <typename Number>
bool parse_number(std::string_view word, Number& value) {
  if (word.starts_with('+')) word.remove_prefix(1);
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  return error == std::errc() && end == word.data() + word.size();
}

double read_coordinate(const ObjText& text, std::string_view word, int line) {
  double value = 0;
  if (!parse_number(word, value) || !std::isfinite(value))
    text.fail(line, "expected a finite number, got '" + std::string(word) + "'");
  return value;
}

// OBJ counts from 1; negative numbers count back from the entries read so far.
int read_index(const ObjText& text, std::string_view word, size_t count, const char* what, int line) {
  int index = 0;
  if (!parse_number(word, index) || index == 0)
    text.fail(line, "expected the number of a " + std::string(what) + " (1, 2, ...), got '" + std::string(word) + "'");
  return index > 0 ? index - 1 : static_cast<int>(count) + index;
}

void read_face(ObjText& text, const std::vector<std::string_view>& words, int line, ObjUse use) {
  if (words.size() != 4)
    text.fail(line, "a face with " + std::to_string(words.size() - 1) +
                        " corners: only triangles are read, so triangulate the mesh");
  ObjFace face{{}, {}, line};
  for (int k = 0; k < 3; ++k) {
    const std::string_view corner = words[k + 1];
    const size_t slash = corner.find('/');
    const std::string_view after = slash == std::string_view::npos ? "" : corner.substr(slash + 1);
    const std::string_view vt = after.substr(0, after.find('/'));
    if (vt.empty() && use == ObjUse::Cloth)
      text.fail(line, "corner '" + std::string(corner) +
                          "' has no texture coordinate: write 'f a/a b/b c/c', with vt = material position in metres");
    face.v[k] = read_index(text, corner.substr(0, slash), text.positions.size(), "vertex", line);
    if (use == ObjUse::Cloth) face.vt[k] = read_index(text, vt, text.texcoords.size(), "texture coordinate", line);
  }
  text.faces.push_back(face);
}

void read_line(ObjText& text, std::string_view content, int line, ObjUse use) {
  const std::vector<std::string_view> words = split_words(content.substr(0, content.find('#')));
  if (words.empty()) return;
  const std::string_view key = words[0];
  if (key == "v") {
    if (words.size() < 4) text.fail(line, "a vertex needs 3 coordinates: v x y z");
    const auto at = [&](int k) { return read_coordinate(text, words[k], line); };
    text.positions.emplace_back(at(1), at(2), at(3));
    text.position_lines.push_back(line);
  } else if (key == "vt") {
    if (words.size() < 3) text.fail(line, "a texture coordinate needs 2 numbers: vt U V");
    text.texcoords.emplace_back(read_coordinate(text, words[1], line), read_coordinate(text, words[2], line));
  } else if (key == "f") {
    read_face(text, words, line, use);
  } else {
    // Names, groups, smoothing, normals, materials and loose points or lines say nothing about the shape.
    constexpr std::array<std::string_view, 9> ignored{"o", "g", "s", "vn", "vp", "usemtl", "mtllib", "p", "l"};
    if (std::find(ignored.begin(), ignored.end(), key) == ignored.end())
      text.fail(line, "unknown statement '" + std::string(key) + "': expected v, vt or f");
  }
}

void check_indices(const ObjText& text, ObjUse use) {
  const auto check = [&](int index, size_t count, const char* what, int line) {
    if (index < 0 || index >= static_cast<int>(count))
      text.fail(line, std::string(what) + " " + std::to_string(index + 1) + " does not exist: the file has " +
                          std::to_string(count));
  };
  for (const ObjFace& face : text.faces) {
    for (int k = 0; k < 3; ++k) check(face.v[k], text.positions.size(), "vertex", face.line);
    for (int k = 0; k < 3 && use == ObjUse::Cloth; ++k)
      check(face.vt[k], text.texcoords.size(), "texture coordinate", face.line);
    for (int k = 0; k < 3; ++k)
      if (face.v[k] == face.v[(k + 1) % 3])
        text.fail(face.line, "vertex " + std::to_string(face.v[k] + 1) + " stands twice in one triangle");
  }
}

}  // namespace

void ObjText::fail(int line, const std::string& what) const {
  throw std::runtime_error(file.string() + ":" + std::to_string(line) + ": " + what);
}

ObjText read_obj_text(const std::filesystem::path& file, ObjUse use) {
  ObjText text{file, {}, {}, {}, {}};
  if (std::filesystem::is_directory(file))
    throw std::runtime_error(file.string() + ": is a directory, not an OBJ file");
  if (std::filesystem::is_character_file(file) || std::filesystem::is_block_file(file))
    throw std::runtime_error(file.string() + ": is a device, not an OBJ file");  // which may have no end
  std::ifstream in(file);
  if (!in) throw std::runtime_error(file.string() + ": cannot be read: " + std::strerror(errno));
  int line = 0;
  for (std::string content; std::getline(in, content);) read_line(text, content, ++line, use);
  if (in.bad()) throw std::runtime_error(file.string() + ": reading failed");
  if (text.faces.empty())
    text.fail(std::max(line, 1),
              "no faces: expected " + std::string(use == ObjUse::Cloth ? "'f a/a b/b c/c'" : "'f a b c'"));
  check_indices(text, use);
  return text;
}

}  // namespace crease
