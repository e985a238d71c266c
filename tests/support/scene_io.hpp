// SPDX-License-Identifier: MIT
#pragma once

// Scene texts read and refused.

#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "crease/stepper/scene_io.hpp"
#include "support/scene_text.hpp"

namespace crease {

using Overrides = std::vector<std::pair<std::string, std::string>>;

class SceneIo : public ::testing::Test {
 protected:
  LoadedScene load(const std::string& text, const Overrides& overrides = {}) const {
    return load_scene(folder_.write("scene.json", text), overrides);
  }

  std::vector<SceneProblem> problems(const std::string& text, const Overrides& overrides = {}) const {
    try {
      load(text, overrides);
    } catch (const SceneError& error) {
      return error.problems();
    }
    return {};
  }

  // The text is refused for exactly one reason, at this pointer, and says this.
  void expect_problem(const std::string& text, const std::string& pointer, const std::string& says,
                      const Overrides& overrides = {}) const {
    const auto found = problems(text, overrides);
    ASSERT_EQ(found.size(), 1u) << ::testing::PrintToString(pointers(found)) << " instead of " << pointer;
    EXPECT_EQ(found[0].pointer, pointer) << found[0].message;
    EXPECT_NE(found[0].message.find(says), std::string::npos) << found[0].message << "\nlacks " << says;
  }

  static std::vector<std::string> pointers(const std::vector<SceneProblem>& found) {
    std::vector<std::string> result;
    for (const SceneProblem& problem : found) result.push_back(problem.pointer);
    return result;
  }

  TestFolder folder_;
};

}  // namespace crease
