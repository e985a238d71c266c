// SPDX-License-Identifier: MIT
#include "crease/solver/qps.hpp"

#include <charconv>
#include <cmath>
#include <istream>
#include <limits>
#include <optional>
#include <ostream>
#include <span>
#include <stdexcept>
#include <string>
#include <unordered_map>
#include <vector>

namespace crease {
namespace {

using Triplet = Eigen::Triplet<double>;
constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr int starts_per_line = 20;

/// Collects lines; a stream would not write the shortest digits.
class Lines {
 public:
  explicit Lines(std::ostream& out) : out_(out) {}
  Lines& word(std::string_view text) {
    line_ += ' ';
    line_ += text;
    return *this;
  }
  Lines& name(char kind, Eigen::Index i) { return word(kind + std::to_string(i)); }
  Lines& number(double value) {
    char text[32];
    return word({text, std::to_chars(text, text + sizeof text, value).ptr});
  }
  void end() {
    out_ << line_ << '\n';
    line_.clear();
  }

 private:
  std::ostream& out_;
  std::string line_;
};

void write_rows_of_column(Lines& lines, char kind, const SparseMatrix& A, int column) {
  for (SparseMatrix::InnerIterator entry(A, column); entry; ++entry)
    lines.name('x', column).name(kind, entry.row()).number(entry.value()).end();
}

void write_bounds_of_rows(Lines& lines, char kind, const VecX& b) {
  for (Eigen::Index i = 0; i < b.size(); ++i)
    if (b[i] != 0) lines.word("RHS").name(kind, i).number(b[i]).end();
}

class Parser {
 public:
  explicit Parser(std::istream& in) : in_(in) {}
  QpProblem parse();

 private:
  /// One of the constraints: which matrix it is in, its row there, and the sign that makes L rows G rows.
  struct Row {
    enum class Kind { Objective, Ignored, Equal, AtLeast } kind;
    int index;
    double sign;
  };
  struct Bounds {
    std::optional<double> lower, upper;
  };

  [[noreturn]] void fail(const std::string& what) const {
    throw std::runtime_error("QPS, line " + std::to_string(line_number_) + ": " + what);
  }
  bool next_line();
  void comment();
  void begin_section();
  void entry();
  void row_entry();
  void column_entry();
  void right_side_entry();
  void bound_entry();
  void hessian_entry();
  double number(const std::string& word) const;
  const Row& row(const std::string& name) const;
  int column(const std::string& name) const;
  std::span<const std::string> pairs() const;
  void add_bounds();
  QpProblem assemble();

  std::istream& in_;
  std::string line_, section_;
  std::vector<std::string> words_;
  int line_number_ = 0;
  std::unordered_map<std::string, Row> rows_;
  std::unordered_map<std::string, int> columns_;
  std::vector<Triplet> H_, equal_, at_least_;
  std::vector<double> f_, b_eq_, b_in_;
  std::vector<Bounds> bounds_;
  std::vector<int> blocks_;
  bool has_objective_ = false;
};

bool Parser::next_line() {
  while (std::getline(in_, line_)) {
    ++line_number_;
    words_.clear();
    constexpr std::string_view space = " \t\r";
    for (std::size_t at = line_.find_first_not_of(space); at != std::string::npos;) {
      const std::size_t end = std::min(line_.find_first_of(space, at), line_.size());
      words_.push_back(line_.substr(at, end - at));
      at = line_.find_first_not_of(space, end);
    }
    if (words_.empty()) continue;
    if (line_[0] != '*') return true;
    comment();
  }
  return false;
}

/// "* blocks 0 3 8" is ours.
void Parser::comment() {
  if (words_.size() < 2 || words_[0] != "*" || words_[1] != "blocks") return;
  for (std::size_t i = 2; i < words_.size(); ++i) {
    int start = 0;
    const std::string& word = words_[i];
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), start);
    if (error != std::errc() || end != word.data() + word.size()) fail("'" + word + "' is not a block's start");
    blocks_.push_back(start);
  }
}

QpProblem Parser::parse() {
  while (next_line()) {
    if (line_[0] == ' ' || line_[0] == '\t')
      entry();
    else
      begin_section();
    if (section_ == "ENDATA") return assemble();
  }
  fail("the file ends without ENDATA");
}

void Parser::begin_section() {
  for (const char* known : {"NAME", "ROWS", "COLUMNS", "RHS", "BOUNDS", "QUADOBJ", "QMATRIX", "ENDATA"})
    if (words_[0] == known) {
      section_ = words_[0];
      return;
    }
  fail("section '" + words_[0] + "' is not supported");
}

void Parser::entry() {
  if (section_ == "ROWS") return row_entry();
  if (section_ == "COLUMNS") return column_entry();
  if (section_ == "RHS") return right_side_entry();
  if (section_ == "BOUNDS") return bound_entry();
  if (section_ == "QUADOBJ" || section_ == "QMATRIX") return hessian_entry();
  fail("an entry outside of the sections that have any");
}

double Parser::number(const std::string& word) const {
  double value = 0;
  const char* begin = word.data() + (word[0] == '+');
  const auto [end, error] = std::from_chars(begin, word.data() + word.size(), value);
  if (error != std::errc() || end != word.data() + word.size() || !std::isfinite(value))
    fail("'" + word + "' is not a finite number");
  return value;
}

const Parser::Row& Parser::row(const std::string& name) const {
  const auto found = rows_.find(name);
  if (found == rows_.end()) fail("there is no row '" + name + "'");
  return found->second;
}

int Parser::column(const std::string& name) const {
  const auto found = columns_.find(name);
  if (found == columns_.end()) fail("there is no column '" + name + "'");
  return found->second;
}

/// The names and numbers behind the first word, which an RHS line may leave out.
std::span<const std::string> Parser::pairs() const {
  const std::size_t skipped = words_.size() % 2;
  if (skipped == 0 && section_ == "COLUMNS") fail("a column, and a row and a number once or twice, were expected");
  if (words_.size() < 2 || words_.size() > 5) fail("a name and a number, once or twice, were expected");
  return std::span(words_).subspan(skipped);
}

void Parser::row_entry() {
  if (words_.size() != 2) fail("a row's type and name were expected");
  const std::string& type = words_[0];
  Row added{Row::Kind::Equal, static_cast<int>(b_eq_.size()), 1};
  if (type == "N") {
    added.kind = has_objective_ ? Row::Kind::Ignored : Row::Kind::Objective;
    has_objective_ = true;
  } else if (type == "E") {
    b_eq_.push_back(0);
  } else if (type == "G" || type == "L") {
    added = {Row::Kind::AtLeast, static_cast<int>(b_in_.size()), type == "G" ? 1.0 : -1.0};
    b_in_.push_back(0);
  } else {
    fail("a row's type is N, E, G or L, not '" + type + "'");
  }
  if (!rows_.emplace(words_[1], added).second) fail("row '" + words_[1] + "' is there already");
}

void Parser::column_entry() {
  if (words_.size() > 1 && words_[1] == "'MARKER'") fail("integers are not supported");
  const auto pair = pairs();
  const auto [found, is_new] = columns_.emplace(words_[0], static_cast<int>(f_.size()));
  if (is_new) {
    f_.push_back(0);
    bounds_.emplace_back();
  }
  for (std::size_t i = 0; i < pair.size(); i += 2) {
    const Row& at = row(pair[i]);
    const double value = at.sign * number(pair[i + 1]);
    if (at.kind == Row::Kind::Objective) f_[static_cast<std::size_t>(found->second)] -= value;
    if (at.kind == Row::Kind::Equal) equal_.emplace_back(at.index, found->second, value);
    if (at.kind == Row::Kind::AtLeast) at_least_.emplace_back(at.index, found->second, value);
  }
}

void Parser::right_side_entry() {
  const auto pair = pairs();
  for (std::size_t i = 0; i < pair.size(); i += 2) {
    const Row& at = row(pair[i]);
    const double value = at.sign * number(pair[i + 1]);
    if (at.kind == Row::Kind::Equal) b_eq_[static_cast<std::size_t>(at.index)] = value;
    if (at.kind == Row::Kind::AtLeast) b_in_[static_cast<std::size_t>(at.index)] = value;
  }
}

void Parser::bound_entry() {
  const std::string& type = words_[0];
  const bool has_value = type == "LO" || type == "UP" || type == "FX";
  if (!has_value && type != "FR" && type != "MI" && type != "PL") fail("bound '" + type + "' is not supported");
  const std::size_t name_at = words_.size() - (has_value ? 2 : 1);  // the set's name may be left out
  if (words_.size() < (has_value ? 3u : 2u) || name_at > 2) fail("a bound's type, column and number were expected");
  Bounds& bounds = bounds_[static_cast<std::size_t>(column(words_[name_at]))];
  const double value = has_value ? number(words_.back()) : 0;
  if (type == "LO" || type == "FX") bounds.lower = value;
  if (type == "UP" || type == "FX") bounds.upper = value;
  if (type == "FR" || type == "MI") bounds.lower = -infinity;
  if (type == "UP" && value < 0 && !bounds.lower)
    fail("an upper bound below 0 needs a lower one (LO or MI) before it: readers differ in what they take for it");
}

void Parser::hessian_entry() {
  if (words_.size() != 3) fail("two columns and a number were expected");
  const int i = column(words_[0]), j = column(words_[1]);
  const double value = number(words_[2]);
  H_.emplace_back(i, j, value);
  if (section_ == "QUADOBJ" && i != j) H_.emplace_back(j, i, value);
}

void Parser::add_bounds() {
  for (int i = 0; i < static_cast<int>(bounds_.size()); ++i) {
    const double lower = bounds_[static_cast<std::size_t>(i)].lower.value_or(0);
    const double upper = bounds_[static_cast<std::size_t>(i)].upper.value_or(infinity);
    for (const auto& [sign, bound] : {std::pair{1.0, lower}, std::pair{-1.0, -upper}}) {
      if (bound == -infinity) continue;
      at_least_.emplace_back(static_cast<int>(b_in_.size()), i, sign);
      b_in_.push_back(bound);
    }
  }
}

QpProblem Parser::assemble() {
  add_bounds();
  const auto vector = [](const std::vector<double>& values) {
    return VecX(Eigen::Map<const VecX>(values.data(), static_cast<Eigen::Index>(values.size())));
  };
  const auto n = static_cast<int>(f_.size());
  QpProblem problem;
  problem.H.resize(n, n);
  problem.H.setFromTriplets(H_.begin(), H_.end());
  problem.f = vector(f_);
  problem.A_eq.resize(static_cast<int>(b_eq_.size()), n);
  problem.A_eq.setFromTriplets(equal_.begin(), equal_.end());
  problem.A_in.resize(static_cast<int>(b_in_.size()), n);
  problem.A_in.setFromTriplets(at_least_.begin(), at_least_.end());
  problem.b_eq = vector(b_eq_);
  problem.b_in = vector(b_in_);
  problem.blocks = blocks_;
  try {
    require_valid(problem);
  } catch (const std::invalid_argument& error) {
    fail(error.what());
  }
  return problem;
}

}  // namespace

void write_qps(std::ostream& out, const QpProblem& problem, std::string_view name) {
  require_valid(problem);
  const SparseMatrix A_eq = problem.A_eq, A_in = problem.A_in;
  const auto n = static_cast<int>(problem.f.size());
  Lines lines(out);
  for (std::size_t i = 0; i < problem.blocks.size(); ++i) {
    if (i % starts_per_line == 0) out << (i ? "\n* blocks" : "* blocks");
    out << ' ' << problem.blocks[i];
  }
  out << (problem.blocks.empty() ? "" : "\n") << "NAME " << name << " FREE\nROWS\n N obj\n";
  for (Eigen::Index i = 0; i < A_eq.rows(); ++i) lines.word("E").name('e', i).end();
  for (Eigen::Index i = 0; i < A_in.rows(); ++i) lines.word("G").name('i', i).end();
  out << "COLUMNS\n";
  for (int i = 0; i < n; ++i) {
    lines.name('x', i).word("obj").number(-problem.f[i]).end();
    write_rows_of_column(lines, 'e', A_eq, i);
    write_rows_of_column(lines, 'i', A_in, i);
  }
  out << "RHS\n";
  write_bounds_of_rows(lines, 'e', problem.b_eq);
  write_bounds_of_rows(lines, 'i', problem.b_in);
  out << "BOUNDS\n";
  for (int i = 0; i < n; ++i) lines.word("FR").word("BND").name('x', i).end();
  out << "QUADOBJ\n";
  for (int i = 0; i < n; ++i)
    for (SparseMatrix::InnerIterator entry(problem.H, i); entry; ++entry)
      if (entry.row() >= i) lines.name('x', i).name('x', entry.row()).number(entry.value()).end();
  out << "ENDATA\n";
}

QpProblem read_qps(std::istream& in) {
  return Parser(in).parse();
}

}  // namespace crease
