// SPDX-License-Identifier: MIT
#pragma once

#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>

#include <gtest/gtest.h>

namespace crease {

/// A folder of the running test, gone afterwards.
class TestFolder {
 public:
  TestFolder() {
    const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
    path_ = std::filesystem::temp_directory_path() /
            ("crease_" + std::string(info->test_suite_name()) + "_" + info->name() + "_" + std::to_string(getpid()));
    std::filesystem::remove_all(path_);
    std::filesystem::create_directories(path_);
  }
  ~TestFolder() { std::filesystem::remove_all(path_); }
  TestFolder(const TestFolder&) = delete;
  TestFolder& operator=(const TestFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }
  std::filesystem::path write(const std::string& name, const std::string& text) const {
    std::ofstream(path_ / name) << text;
    return path_ / name;
  }

 private:
  std::filesystem::path path_;
};

/// The text with its first `what` replaced, so that a test shows only what it changes.
inline std::string with(std::string text, const std::string& what, const std::string& by) {
  const size_t at = text.find(what);
  if (at == std::string::npos) throw std::logic_error("the scene does not hold " + what);
  return text.replace(at, what.size(), by);
}

/// The smallest scene of the format.
constexpr char smallest_scene[] = R"({
  "format": 1, "name": "small", "duration": 1,
  "cloths": [{"shape": {"grid": {}}, "material": {}}]
})";

/// A scene that gives a value to every key that can be run.
constexpr char full_scene[] = R"({
  // every key of the format
  "format": 1, "name": "edge", "description": "all of it", "duration": 4.0, "time_step": 0.005, "gravity": [0, 0, -9.81],
  "cloths": [{
    "name": "sheet",
    "shape": {"grid": {"size": [1, 1], "cells": [8, 8], "pattern": "cross", "seed": 1}},
    "placement": {"origin": [0, 0, 0], "u": [1, 0, 0], "v": [0, 1, 0]},
    "velocity": [0, 0, 0],
    "material": {"density": 0.05, "youngs": 50, "poisson": 0.3, "bending": 1e-5, "damping": 0.0},
    "remeshing": {"method": "conformal", "size": [0.02, 0.2], "angle": 0.3, "velocity": 0.5, "compression": 0.005,
                  "aspect": 0.2},
    "pins": [{"where": {"corner": "10"}, "axes": "xyz",
              "motion": [{"time": 0, "velocity": [0, 0, 0]}, {"time": 0.35, "velocity": [0.1, 0, 0]}], "ramp": 0.1,
              "release": 2.0}]
  }],
  "obstacles": [
    {"name": "table", "box": {"size": [1.2, 1.5, 1.0]}, "position": [0.9175, 0.4425, -0.549],
     "rotation": {"axis": [0, 0, 1], "degrees": 0},
     "motion": [{"time": 0, "velocity": [0, 0, 0], "angular_velocity": [0, 0, 0]}]}
  ],
  "contact": {"method": "eol", "threshold": 0.001, "friction": 0.0, "self": false},
  "dynamics": {"velocity_terms": true, "integrator": "linear"},
  "solver": {"qp": "active_set", "tolerance": 1e-8},
  "output": {"fps": 60, "formats": ["vtp"]}
})";

}  // namespace crease
