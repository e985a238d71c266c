// SPDX-License-Identifier: MIT
#include "crease/geometry/obj_io.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <fstream>
#include <ostream>
#include <stdexcept>
#include <string_view>
#include <utility>

#include "crease/base/require.hpp"

namespace crease {
namespace {

// A triangle whose area is below this share of its longest edge squared is a line, whatever sign rounding gave it:
// three coordinates of size 1 that lie on a line yield an area of about 1e-16.
constexpr double zero_area = 1e-12;

struct ObjFace {
  std::array<int, 3> v, vt;  // 0-based
  int line;
};

struct ObjText {
  std::filesystem::path file;
  std::vector<Vec3> positions;
  std::vector<int> position_lines;
  std::vector<Vec2> texcoords;
  std::vector<ObjFace> faces;

  [[noreturn]] void fail(int line, const std::string& what) const {
    throw std::runtime_error(file.string() + ":" + std::to_string(line) + ": " + what);
  }
};

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

void read_face(ObjText& text, const std::vector<std::string_view>& words, int line) {
  if (words.size() != 4)
    text.fail(line, "a face with " + std::to_string(words.size() - 1) +
                        " corners: only triangles are read, so triangulate the mesh");
  ObjFace face{{}, {}, line};
  for (int k = 0; k < 3; ++k) {
    const std::string_view corner = words[k + 1];
    const size_t slash = corner.find('/');
    const std::string_view after = slash == std::string_view::npos ? "" : corner.substr(slash + 1);
    const std::string_view vt = after.substr(0, after.find('/'));
    if (vt.empty())
      text.fail(line, "corner '" + std::string(corner) +
                          "' has no texture coordinate: write 'f a/a b/b c/c', with vt = material position in metres");
    face.v[k] = read_index(text, corner.substr(0, slash), text.positions.size(), "vertex", line);
    face.vt[k] = read_index(text, vt, text.texcoords.size(), "texture coordinate", line);
  }
  text.faces.push_back(face);
}

void read_line(ObjText& text, std::string_view content, int line) {
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
    read_face(text, words, line);
  } else {
    // Names, groups, smoothing, normals, materials and loose points or lines say nothing about a cloth.
    constexpr std::array<std::string_view, 9> ignored{"o", "g", "s", "vn", "vp", "usemtl", "mtllib", "p", "l"};
    if (std::find(ignored.begin(), ignored.end(), key) == ignored.end())
      text.fail(line, "unknown statement '" + std::string(key) + "': expected v, vt or f");
  }
}

ObjText read_text(const std::filesystem::path& file) {
  ObjText text{file, {}, {}, {}, {}};
  if (std::filesystem::is_directory(file))
    throw std::runtime_error(file.string() + ": is a directory, not an OBJ file");
  std::ifstream in(file);
  if (!in) throw std::runtime_error(file.string() + ": cannot be read: " + std::strerror(errno));
  int line = 0;
  for (std::string content; std::getline(in, content);) read_line(text, content, ++line);
  if (in.bad()) throw std::runtime_error(file.string() + ": reading failed");
  if (text.faces.empty()) text.fail(std::max(line, 1), "no faces: expected 'f a/a b/b c/c'");
  return text;
}

void check_indices(const ObjText& text) {
  const auto check = [&](int index, size_t count, const char* what, int line) {
    if (index < 0 || index >= static_cast<int>(count))
      text.fail(line, std::string(what) + " " + std::to_string(index + 1) + " does not exist: the file has " +
                          std::to_string(count));
  };
  for (const ObjFace& face : text.faces) {
    for (int k = 0; k < 3; ++k) check(face.v[k], text.positions.size(), "vertex", face.line);
    for (int k = 0; k < 3; ++k) check(face.vt[k], text.texcoords.size(), "texture coordinate", face.line);
    for (int k = 0; k < 3; ++k)
      if (face.v[k] == face.v[(k + 1) % 3])
        text.fail(face.line, "vertex " + std::to_string(face.v[k] + 1) + " stands twice in one triangle");
  }
}

// One material position a vertex; a seam would need two.
std::vector<Vec2> material_positions(const ObjText& text) {
  std::vector<int> texcoord(text.positions.size(), -1);
  for (const ObjFace& face : text.faces)
    for (int k = 0; k < 3; ++k) {
      int& known = texcoord[face.v[k]];
      if (known >= 0 && text.texcoords[known] != text.texcoords[face.vt[k]])
        text.fail(face.line, "vertex " + std::to_string(face.v[k] + 1) + " has two texture coordinates, " +
                                 std::to_string(known + 1) + " and " + std::to_string(face.vt[k] + 1) +
                                 ": seams are not available yet, so give each vertex one");
      known = face.vt[k];
    }
  std::vector<Vec2> X(text.positions.size());
  for (size_t i = 0; i < X.size(); ++i) {
    if (texcoord[i] < 0)
      text.fail(text.position_lines[i], "vertex " + std::to_string(i + 1) + " is in no triangle: remove it");
    X[i] = text.texcoords[texcoord[i]];
  }
  return X;
}

void check_areas(const ObjText& text, const std::vector<Vec2>& X) {
  for (const ObjFace& face : text.faces) {
    const Vec2 a = X[face.v[1]] - X[face.v[0]], b = X[face.v[2]] - X[face.v[0]];
    const double twice_area = a.x() * b.y() - a.y() * b.x();
    const double longest = std::max({a.squaredNorm(), b.squaredNorm(), (a - b).squaredNorm()});
    if (!(std::abs(twice_area) > 2 * zero_area * longest))
      text.fail(face.line, "triangle of zero area in material space (vt): remove it or move its corners apart");
    if (twice_area < 0)
      text.fail(face.line, "triangle is inverted in material space (vt): its corners must run counter-clockwise there");
  }
}

// With consistent orientation a directed edge belongs to one face at most; a third face at an edge repeats a direction.
void check_manifold(const ObjText& text) {
  std::vector<std::pair<std::array<int, 2>, int>> directed;  // edge, line
  for (const ObjFace& face : text.faces)
    for (int k = 0; k < 3; ++k) directed.push_back({{face.v[k], face.v[(k + 1) % 3]}, face.line});
  std::sort(directed.begin(), directed.end());
  for (size_t i = 1; i < directed.size(); ++i)
    if (directed[i].first == directed[i - 1].first) {
      const auto& [edge, line] = directed[i];
      text.fail(line, "edge " + std::to_string(edge[0] + 1) + "-" + std::to_string(edge[1] + 1) +
                          " runs the same way in two triangles (the other on line " +
                          std::to_string(directed[i - 1].second) + "): the mesh is not manifold there");
    }
  std::vector<char> fans(text.positions.size(), 0);
  for (const auto& [edge, line] : directed) {
    const std::array<int, 2> back{edge[1], edge[0]};
    const auto it = std::lower_bound(directed.begin(), directed.end(), std::pair(back, 0));
    if (it != directed.end() && it->first == back) continue;
    if (fans[edge[0]]++ > 0)
      text.fail(line, "vertex " + std::to_string(edge[0] + 1) +
                          " joins two pieces that share nothing else: the mesh is not manifold there; duplicate it");
  }
}

// Shortest decimal that reads back as the same double.
void append(std::string& out, double value) {
  std::array<char, 32> digits;
  const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr;
  out.append(digits.data(), end);
}

void append_faces(std::string& out, const Mesh& mesh, int offset) {
  for (int f = 0; f < mesh.n_faces(); ++f) {
    out += 'f';
    for (const int v : mesh.face(f)) {
      const std::string index = std::to_string(offset + v + 1);
      out.append(" ").append(index).append("/").append(index);
    }
    out += '\n';
  }
}

}  // namespace

Mesh read_obj(const std::filesystem::path& file) {
  ObjText text = read_text(file);
  check_indices(text);
  std::vector<Vec2> X = material_positions(text);
  check_areas(text, X);
  check_manifold(text);
  std::vector<std::array<int, 3>> faces;
  for (const ObjFace& face : text.faces) faces.push_back(face.v);
  try {
    return Mesh(std::move(X), std::move(text.positions), faces);
  } catch (const std::invalid_argument& error) {
    throw std::runtime_error(file.string() + ": " + error.what());
  }
}

void write_obj(std::ostream& out, std::span<const NamedCloth> cloths, double time) {
  for (const NamedCloth& named : cloths)
    require(named.cloth && named.cloth->mesh.is_compact(), "write_obj: expected compact cloths");
  std::string text = "# time ";
  append(text, time);
  text += "\n# eol";
  int offset = 0;
  for (const NamedCloth& named : cloths) {
    for (int i = 0; i < named.cloth->mesh.n_vertices(); ++i)
      if (named.cloth->is_eol(i)) text.append(" ").append(std::to_string(offset + i + 1));
    offset += named.cloth->mesh.n_vertices();
  }
  text += '\n';
  offset = 0;
  for (const NamedCloth& named : cloths) {
    const Mesh& mesh = named.cloth->mesh;
    if (cloths.size() > 1) text.append("o ").append(named.name).append("\n");
    for (const Vec3& x : mesh.x) {
      text += 'v';
      for (const double coordinate : x) append(text += ' ', coordinate);
      text += '\n';
    }
    for (const Vec2& X : mesh.X) {
      append(text += "vt ", X.x());
      append(text += ' ', X.y());
      text += '\n';
    }
    append_faces(text, mesh, offset);
    offset += mesh.n_vertices();
  }
  out.write(text.data(), static_cast<std::streamsize>(text.size()));
}

}  // namespace crease
