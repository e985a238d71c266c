// SPDX-License-Identifier: MIT
// Obstacles from mesh files, and the methods of contact that a scene may ask for.
#include "support/scene_io.hpp"

namespace crease {
namespace {

// A box of 12 triangles, from a file beside the scene.
std::string box_obj() {
  std::string text;
  const ObstacleShape box = make_box({1, 2, 3});
  for (const Vec3& p : box.vertices)
    text += "v " + std::to_string(p.x()) + " " + std::to_string(p.y()) + " " + std::to_string(p.z()) + "\n";
  for (const auto& [a, b, c] : box.triangles)
    text += "f " + std::to_string(a + 1) + " " + std::to_string(b + 1) + " " + std::to_string(c + 1) + "\n";
  return text;
}

TEST_F(SceneIo, MeshObstaclesAreReadFromFilesBesideTheScene) {
  folder_.write("rock.obj", box_obj());
  const std::string box = "\"box\": {\"size\": [1.2, 1.5, 1.0]}";
  const auto scene = load(with(full_scene, box, "\"mesh\": {\"file\": \"./rock.obj\"}"));
  const Obstacle& rock = scene.scene.obstacles.at(0);
  EXPECT_EQ(rock.shape.kind, ObstacleShape::Kind::Mesh);
  EXPECT_EQ(rock.shape.edges.size(), 12u);
  EXPECT_EQ(rock.start.position, Vec3(0.9175, 0.4425, -0.549));
  // 90 degrees are not sharp if 120 are asked for; and the resolved scene finds its file from anywhere.
  const std::string round = "\"mesh\": {\"file\": \"rock.obj\", \"sharp_angle\": 120}";
  const LoadedScene smooth = load(with(full_scene, box, round));
  EXPECT_TRUE(smooth.scene.obstacles.at(0).shape.edges.empty());
  EXPECT_NE(smooth.resolved_json.find((folder_.path() / "rock.obj").string()), std::string::npos);
}

TEST_F(SceneIo, MeshObstaclesThatAreNoSolidAreRefusedWithAllTheirProblems) {
  folder_.write("rock.obj", box_obj());
  std::string open = box_obj();
  open.resize(open.rfind("f "));
  folder_.write("open.obj", open);
  folder_.write("quad.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n");
  folder_.write("short.obj", "v 0 0 0\nv 1 0 0\nf 1 2 3\n");
  const std::string box = "\"box\": {\"size\": [1.2, 1.5, 1.0]}";
  struct Case {
    std::string by, pointer, says;
  };
  for (const auto& [by, pointer, says] : std::vector<Case>{
           {"\"mesh\": {}", "/obstacles/0/mesh/file", "is missing"},
           {"\"mesh\": {\"file\": \"none.obj\"}", "/obstacles/0/mesh/file", "cannot be read"},
           {"\"mesh\": {\"file\": \"open.obj\"}", "/obstacles/0/mesh/file", "is not closed"},
           {"\"mesh\": {\"file\": \"quad.obj\"}", "/obstacles/0/mesh/file", "quad.obj:5: a face with 4 corners"},
           {"\"mesh\": {\"file\": \"short.obj\"}", "/obstacles/0/mesh/file", "short.obj:3: vertex 3 does not exist"},
           {"\"mesh\": {\"file\": \"rock.obj\", \"sharp_angle\": 0}", "/obstacles/0/mesh/sharp_angle",
            "must be a number > 0"},
           {box + ", \"mesh\": {\"file\": \"rock.obj\"}", "/obstacles/0", "exactly one of box, point, wire, mesh"}}) {
    SCOPED_TRACE(by);
    expect_problem(with(full_scene, box, by), pointer, says);
  }
}

TEST_F(SceneIo, LagrangianMethodsRunOnEveryMesh) {
  for (const auto& [name, method] : {std::pair("\"lagrangian_averaged\"", ContactMethod::LagrangianAveraged),
                                     std::pair("\"lagrangian_cone\"", ContactMethod::LagrangianCone)})
    for (const std::string remeshing : {"none", "adaptive", "conformal"}) {
      const std::string text = with(full_scene, "\"eol\"", name);
      EXPECT_EQ(load(text, {{"cloths.0.remeshing.method", remeshing}}).scene.contact, method);
    }
}

}  // namespace
}  // namespace crease
