// SPDX-License-Identifier: MIT
// The files of a run, read back by readers that know the formats' rules and nothing of the writers.
#include "support/scene_text.hpp"

#include <cstdint>
#include <cstring>
#include <map>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "crease/stepper/run.hpp"
#include "support/frames.hpp"
#include "support/runs.hpp"

namespace crease {
namespace {

using namespace testing;

struct Array {
  std::string type;
  int components = 1;
  std::vector<double> values;
  Vec3 vec3(int i) const { return {values[3 * i], values[3 * i + 1], values[3 * i + 2]}; }
  Vec2 vec2(int i) const { return {values[2 * i], values[2 * i + 1]}; }
};

struct PolyData {
  double time = -1;
  int n_points = -1, n_polys = -1;
  std::map<std::string, Array> point_data, cell_data, topology;
};

/// Value of the first attribute of that name, "" if there is none.
std::string attribute(const std::string& text, const std::string& name) {
  const std::string key = " " + name + "=\"";
  const std::size_t at = text.find(key);
  if (at == std::string::npos) return "";
  const std::size_t begin = at + key.size();
  return text.substr(begin, text.find('"', begin) - begin);
}

/// VTK's rules: an appended array is a UInt64 byte count and the raw values, at `offset` bytes after the underscore.
Array read_array(const std::string& element, const std::string& raw) {
  Array array{attribute(element, "type"), std::stoi(attribute(element, "NumberOfComponents")), {}};
  const std::size_t at = std::stoul(attribute(element, "offset"));
  std::uint64_t bytes = 0;
  std::memcpy(&bytes, raw.data() + at, sizeof bytes);
  const char* data = raw.data() + at + sizeof bytes;
  const auto take = [&]<class T>(T) {
    for (std::uint64_t i = 0; i < bytes; i += sizeof(T)) {
      T value;
      std::memcpy(&value, data + i, sizeof value);
      array.values.push_back(static_cast<double>(value));
    }
  };
  if (array.type == "Float64") take(double{});
  if (array.type == "Int32") take(std::int32_t{});
  if (array.type == "UInt8") take(std::uint8_t{});
  return array;
}

PolyData read_vtp(const fs::path& file) {
  const std::string text = bytes_of(file);
  const std::string mark = "<AppendedData encoding=\"raw\">";
  const std::size_t split = text.find(mark);
  EXPECT_NE(split, std::string::npos);
  const std::string head = text.substr(0, split), raw = text.substr(text.find('_', split) + 1);
  PolyData data;
  EXPECT_EQ(attribute(head, "header_type"), "UInt64");
  EXPECT_EQ(attribute(head, "byte_order"), "LittleEndian");
  EXPECT_EQ(attribute(head, "TCoords"), "uv");
  data.n_points = std::stoi(attribute(head, "NumberOfPoints"));
  data.n_polys = std::stoi(attribute(head, "NumberOfPolys"));
  std::string section;
  for (std::size_t at = head.find('<'); at != std::string::npos; at = head.find('<', at + 1)) {
    const std::size_t end = head.find('>', at);
    const std::string element = head.substr(at, end - at),
                      name = element.substr(1, element.find_first_of(" />", 1) - 1);
    if (name.empty()) continue;  // a closing tag
    if (name != "DataArray") {
      section = name;
    } else if (section == "FieldData") {
      EXPECT_EQ(attribute(element, "Name"), "TimeValue");
      data.time = std::stod(head.substr(end + 1));
    } else {
      auto& arrays = section == "CellData" ? data.cell_data : section == "PointData" ? data.point_data : data.topology;
      arrays[attribute(element, "Name")] = read_array(element, raw);
    }
  }
  return data;
}

TEST(Vtp, AgreesWithTheObjOfTheSameFrame) {
  const TestFolder folder;
  ASSERT_EQ(run_scene(hanging_scene(), {.directory = folder.path()}).status, RunStatus::Done);
  const PolyData vtp = read_vtp(folder.path() / "frames/000007.vtp");
  const Frame obj = read_frame(folder.path() / "frames/000007.obj");
  EXPECT_EQ(vtp.time, obj.time);
  ASSERT_EQ(vtp.n_points, static_cast<int>(obj.x.size()));
  ASSERT_EQ(vtp.n_polys, static_cast<int>(obj.faces.size()));
  ASSERT_EQ(vtp.topology.at("Points").values.size(), 3 * obj.x.size());
  for (int i = 0; i < vtp.n_points; ++i) {
    EXPECT_EQ(vtp.topology.at("Points").vec3(i), obj.x[i]);  // both keep every digit
    EXPECT_EQ(vtp.point_data.at("uv").vec2(i), obj.X[i]);
    EXPECT_EQ(vtp.point_data.at("eol").values[i], 0);
    EXPECT_EQ(vtp.point_data.at("material_velocity").vec3(i), Vec3(0, 0, 0));
  }
  for (int f = 0; f < vtp.n_polys; ++f) {
    EXPECT_EQ(vtp.topology.at("offsets").values[f], 3 * (f + 1));
    for (int k = 0; k < 3; ++k) EXPECT_EQ(vtp.topology.at("connectivity").values[3 * f + k], obj.faces[f][k]);
  }
}

TEST(Vtp, MarksEulerianVerticesAndTheirMotion) {
  const TestFolder folder;
  LoadedScene loaded = table_scene();
  loaded.scene.formats = {FrameFormat::Vtp, FrameFormat::Obj};
  ASSERT_EQ(run_scene(loaded, {.directory = folder.path()}).status, RunStatus::Done);
  const PolyData vtp = read_vtp(folder.path() / "frames/000010.vtp");
  const Frame obj = read_frame(folder.path() / "frames/000010.obj");
  ASSERT_FALSE(obj.eol.empty());
  std::vector<double> eol(obj.x.size(), 0.0);
  for (const int v : obj.eol) eol[v] = 1;
  EXPECT_EQ(vtp.point_data.at("eol").values, eol);
  double slide = 0;
  for (const int v : obj.eol) slide += vtp.point_data.at("material_velocity").vec3(v).norm();
  EXPECT_GT(slide, 0.0);
}

TEST(Vtp, HoldsAllSheetsAndTellsThemApart) {
  const TestFolder folder;
  LoadedScene loaded = hanging_scene();
  ClothSpec second = hanging_sheet();
  second.shape = GridOptions{.cells = {1, 1}};
  add_sheet(loaded, second);
  ASSERT_EQ(run_scene(loaded, {.directory = folder.path(), .until = 0.005}).status, RunStatus::Done);
  const PolyData vtp = read_vtp(folder.path() / "frames/000000.vtp");
  ASSERT_EQ(vtp.n_points, 25 + 5);  // 4 x 4 lattice points and 9 centres; 4 and 1
  ASSERT_EQ(vtp.n_polys, 36 + 4);
  for (int f = 0; f < vtp.n_polys; ++f) {
    EXPECT_EQ(vtp.cell_data.at("cloth").values[f], f < 36 ? 0 : 1);
    for (int k = 0; k < 3; ++k) {
      const int v = static_cast<int>(vtp.topology.at("connectivity").values[3 * f + k]);
      EXPECT_EQ(vtp.point_data.at("cloth").values[v], f < 36 ? 0 : 1);
    }
  }
}

TEST(StepsCsv, BeginsWithTheColumnsThatAreFixed) {
  const TestFolder folder;
  ASSERT_EQ(run_scene(hanging_scene(), {.directory = folder.path(), .until = 0.005}).status, RunStatus::Done);
  EXPECT_TRUE(
      bytes_of(folder.path() / "steps.csv")
          .starts_with("step,time,time_step,faces,vertices,eol_vertices,contacts,active_constraints,qp_iterations,"
                       "kkt_residual,retries,kinetic_energy,membrane_energy,bending_energy,gravitational_energy,"
                       "momentum_x,momentum_y,momentum_z,max_penetration,t_detect,t_remesh,t_transfer,t_assemble,"
                       "t_constrain,t_solve,t_integrate,t_output,t_total,"));
}

// Velocity is linear on each triangle, so its integral is area/3 times the sum at the corners.
TEST(StepsCsv, MomentumIsThatOfTheFrameOfTheSameTime) {
  const TestFolder folder;
  const LoadedScene loaded = hanging_scene();
  ASSERT_EQ(run_scene(loaded, {.directory = folder.path()}).status, RunStatus::Done);
  auto steps = read_steps(folder.path());
  int compared = 0;
  for (int k = 1; k <= 13; ++k) {
    char name[32];
    std::snprintf(name, sizeof name, "frames/%06d.vtp", k);
    const PolyData vtp = read_vtp(folder.path() / name);
    Vec3 momentum = Vec3::Zero();
    for (int f = 0; f < vtp.n_polys; ++f) {
      const auto corner = [&](int c) { return static_cast<int>(vtp.topology.at("connectivity").values[3 * f + c]); };
      const Array &uv = vtp.point_data.at("uv"), &velocity = vtp.point_data.at("velocity");
      const Vec2 a = uv.vec2(corner(1)) - uv.vec2(corner(0)), b = uv.vec2(corner(2)) - uv.vec2(corner(0));
      const double mass = loaded.scene.cloths[0].material.density * 0.5 * (a.x() * b.y() - a.y() * b.x());
      for (int c = 0; c < 3; ++c) momentum += mass / 3 * velocity.vec3(corner(c));
    }
    for (std::size_t row = 0; row < steps["time"].size(); ++row) {
      if (steps["time"][row] != vtp.time) continue;
      const Vec3 told(steps["momentum_x"][row], steps["momentum_y"][row], steps["momentum_z"][row]);
      EXPECT_LE((told - momentum).norm(), 1e-14);  // sums of 36 terms of about 1e-3 kg m/s
      ++compared;
    }
  }
  EXPECT_EQ(compared, 13);
}

// The sheet is 1 m^2 of 0.05 kg/m^2 and free, so what it carries changes between two remeshings by the step alone.
TEST(StepsCsv, ShowsWhatRemeshingFoundAndLeft) {
  const TestFolder folder;
  const LoadedScene loaded = table_scene();
  ASSERT_EQ(run_scene(loaded, {.directory = folder.path() / "table"}).status, RunStatus::Done);
  auto steps = read_steps(folder.path() / "table");
  double operations = 0;
  for (std::size_t k = 0; k < steps["step"].size(); ++k) {
    SCOPED_TRACE("step " + std::to_string(k + 1));
    operations += steps["splits"][k] + steps["flips"][k] + steps["collapses"][k];
    for (const char* when : {"before", "after"})  // sums of some 100 areas
      EXPECT_NEAR(steps[std::string("mass_") + when + "_remesh"][k], 0.05, 1e-15);
    // Momentum is about 0.05 kg times 2 m/s; it may jump by 1e-12 of it.
    for (const std::string part : {"momentum_x", "momentum_y", "momentum_z", "kinetic_energy"}) {
      const double before = steps[part + "_before_remesh"][k];
      if (part != "kinetic_energy") {
        EXPECT_NEAR(before, steps[part + "_after_remesh"][k], 1e-13) << part;
      }
      if (k == 0 || steps["retries"][k] > 0) continue;
      EXPECT_NEAR(before, steps[part][k - 1], 1e-13) << part;
    }
    // Not raised, but for the rounding of sums over some 100 faces.
    EXPECT_LE(steps["kinetic_energy_after_remesh"][k], steps["kinetic_energy_before_remesh"][k] * (1 + 1e-13));
  }
  EXPECT_GT(operations, 0);
  ASSERT_EQ(run_scene(hanging_scene(), {.directory = folder.path() / "plain", .until = 0.01}).status, RunStatus::Done);
  for (const char* column : {"mass_before_remesh", "mass_after_remesh", "kinetic_energy_after_remesh"})
    EXPECT_EQ(read_steps(folder.path() / "plain")[column], (std::vector<double>{0, 0})) << "not remeshed";
}

TEST(ObstaclesJson, PlacesEveryObstacleAtEveryFrame) {
  const TestFolder folder;
  LoadedScene loaded = hanging_scene();
  Obstacle box;
  box.name = "spinning";
  box.shape = make_box({0.1, 0.2, 0.3});
  box.start.position = {5, 0, 0};
  box.motion = {{.time = 0, .velocity = {0.5, 0, 0}, .angular_velocity = {0, 0, 2}}};
  loaded.scene.obstacles = {box};
  ASSERT_EQ(run_scene(loaded, {.directory = folder.path()}).status, RunStatus::Done);
  const auto json = nlohmann::json::parse(bytes_of(folder.path() / "obstacles.json"))["obstacles"][0];
  EXPECT_EQ(json["name"], "spinning");
  EXPECT_EQ(json["kind"], "box");
  EXPECT_EQ(json["vertices"].size(), 8u);
  EXPECT_EQ(json["triangles"].size(), 12u);
  EXPECT_EQ(json["sharp_edges"].size(), 12u);
  ASSERT_EQ(json["poses"].size(), 14u);
  for (int k = 0; k < 14; ++k) {
    const auto& pose = json["poses"][k];
    const double time =
        read_frame(folder.path() / ("frames/0000" + std::string(k < 10 ? "0" : "") + std::to_string(k) + ".obj")).time;
    EXPECT_EQ(pose["time"], time);
    // 1e-14: round-off of numbers about 5.
    EXPECT_NEAR(pose["position"][0].get<double>(), 5 + 0.5 * time, 1e-14);
    EXPECT_NEAR(pose["rotation"][0][0].get<double>(), std::cos(2 * time), 1e-14);
    EXPECT_NEAR(pose["rotation"][1][0].get<double>(), std::sin(2 * time), 1e-14);
  }
}

TEST(SummaryJson, AddsUpTheRows) {
  const TestFolder folder;
  ASSERT_EQ(run_scene(hanging_scene(), {.directory = folder.path(), .command_line = "crease run hanging"}).status,
            RunStatus::Done);
  auto steps = read_steps(folder.path());
  const auto summary = nlohmann::json::parse(bytes_of(folder.path() / "summary.json"));
  EXPECT_TRUE(summary["finished"]);
  EXPECT_EQ(summary["steps"], 45);
  EXPECT_EQ(summary["frames"], 14);
  EXPECT_EQ(summary["command_line"], "crease run hanging");
  double wall = 0, shares = 0;
  for (const double t : steps["t_total"]) wall += t;
  EXPECT_NEAR(summary["wall_s"], wall, 1e-6 * 45);  // a row keeps microseconds
  for (const auto& [stage, entry] : summary["stages"].items()) shares += entry["share"].get<double>();
  EXPECT_NEAR(shares, 1.0, 0.01);
  for (const char* library : {"eigen", "suitesparse", "ipopt", "fcl", "nlohmann_json"})
    EXPECT_FALSE(summary["libraries"][library].get<std::string>().empty()) << library;
}

TEST(SceneJson, IsTheResolvedSceneItself) {
  const TestFolder folder;
  const LoadedScene loaded = hanging_scene();
  ASSERT_EQ(run_scene(loaded, {.directory = folder.path(), .until = 0.005}).status, RunStatus::Done);
  EXPECT_EQ(bytes_of(folder.path() / "scene.json"), loaded.resolved_json);
}

}  // namespace
}  // namespace crease
