// SPDX-License-Identifier: MIT
#pragma once

// Frames of a run as anyone outside sees them: OBJ text read back, and measures on the triangles alone.

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "crease/base/types.hpp"
#include "crease/geometry/distance.hpp"

namespace crease::testing {

struct Frame {
  double time = 0;
  std::vector<Vec3> x;
  std::vector<Vec2> X;
  std::vector<std::array<int, 3>> faces;
  std::vector<int> eol;  // 0-based
  double released = 0;   // EOL vertices let go until then, where the run tells
};

inline Frame read_frame(const std::filesystem::path& file) {
  std::ifstream in(file);
  Frame frame;
  for (std::string line; std::getline(in, line);) {
    std::istringstream words(line);
    std::string word;
    words >> word;
    if (word == "#") {
      words >> word;
      if (word == "time") words >> frame.time;
      if (word == "eol")
        for (int i; words >> i;) frame.eol.push_back(i - 1);
    } else if (word == "v") {
      Vec3 p;
      words >> p[0] >> p[1] >> p[2];
      frame.x.push_back(p);
    } else if (word == "vt") {
      Vec2 p;
      words >> p[0] >> p[1];
      frame.X.push_back(p);
    } else if (word == "f") {
      std::array<int, 3> face{};
      for (int& corner : face) {
        words >> word;
        corner = std::stoi(word) - 1;  // "a/a": v and vt have the same index
      }
      frame.faces.push_back(face);
    }
  }
  return frame;
}

inline std::vector<Frame> read_frames(const std::filesystem::path& directory) {
  std::set<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(directory / "frames"))
    if (entry.path().extension() == ".obj") files.insert(entry.path());
  std::vector<Frame> frames;
  for (const auto& file : files) frames.push_back(read_frame(file));
  return frames;
}

/// Distance from a world point to the nearest triangle.
inline double distance_to_surface(const Frame& frame, const Vec3& p) {
  double best = 1e300;
  for (const auto& f : frame.faces) {
    const std::array<Vec3, 3> corners{frame.x[f[0]], frame.x[f[1]], frame.x[f[2]]};
    const Vec3 low = corners[0].cwiseMin(corners[1]).cwiseMin(corners[2]).array() - best;
    const Vec3 high = corners[0].cwiseMax(corners[1]).cwiseMax(corners[2]).array() + best;
    if ((p.array() < low.array()).any() || (p.array() > high.array()).any()) continue;
    const Vec3 b = closest_on_triangle(p, corners);
    best = std::min(best, (p - b[0] * corners[0] - b[1] * corners[1] - b[2] * corners[2]).norm());
  }
  return best;
}

/// Deepest point inside an axis-aligned box, sampled on a level-4 lattice of every triangle; 0 if none.
inline double box_penetration(const Frame& frame, const Vec3& low, const Vec3& high) {
  constexpr int level = 4;
  double deepest = 0;
  for (const auto& f : frame.faces)
    for (int i = 0; i <= level; ++i)
      for (int j = 0; j <= level - i; ++j) {
        const Vec3 p = (i * frame.x[f[0]] + j * frame.x[f[1]] + (level - i - j) * frame.x[f[2]]) / level;
        deepest = std::max(deepest, std::min((p - low).minCoeff(), (high - p).minCoeff()));
      }
  return deepest;
}

/// World position that the frame gives to a material point; nearest face if the point is outside all by round-off.
inline Vec3 world_of(const Frame& frame, const Vec2& X) {
  double best = -1e300;
  Vec3 result = Vec3::Zero();
  for (const auto& f : frame.faces) {
    const Vec2 &a = frame.X[f[0]], &b = frame.X[f[1]], &c = frame.X[f[2]];
    const double area = (b - a).x() * (c - a).y() - (b - a).y() * (c - a).x();
    const double beta = ((X - a).x() * (c - a).y() - (X - a).y() * (c - a).x()) / area;
    const double gamma = ((b - a).x() * (X - a).y() - (b - a).y() * (X - a).x()) / area;
    const double inside = std::min({beta, gamma, 1 - beta - gamma});
    if (inside > best) {
      best = inside;
      result = (1 - beta - gamma) * frame.x[f[0]] + beta * frame.x[f[1]] + gamma * frame.x[f[2]];
    }
    if (inside > -1e-12) break;
  }
  return result;
}

/// Largest speed of a material point between two frames relative to the mean of its mesh neighbours' speeds.
inline double largest_jump(const Frame& before, const Frame& after) {
  std::vector<Vec3> speed(after.x.size());
  for (std::size_t i = 0; i < after.x.size(); ++i)
    speed[i] = (after.x[i] - world_of(before, after.X[i])) / (after.time - before.time);
  std::vector<Vec3> sum(after.x.size(), Vec3::Zero());
  std::vector<int> count(after.x.size(), 0);
  for (const auto& f : after.faces)
    for (int k = 0; k < 3; ++k) {
      for (const int other : {f[(k + 1) % 3], f[(k + 2) % 3]}) {
        sum[f[k]] += speed[other];
        ++count[f[k]];
      }
    }
  double largest = 0;
  for (std::size_t i = 0; i < after.x.size(); ++i) largest = std::max(largest, (speed[i] - sum[i] / count[i]).norm());
  return largest;
}

}  // namespace crease::testing
