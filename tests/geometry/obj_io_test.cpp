// SPDX-License-Identifier: MIT
#include "crease/geometry/obj_io.hpp"

#include <gtest/gtest.h>

#include <bit>
#include <cstdint>
#include <fstream>
#include <random>
#include <sstream>

#include "crease/geometry/grid.hpp"
#include "support/seams.hpp"

namespace crease {
namespace {

// A file in a folder of its own, gone afterwards.
class ObjFile : public testing::Test {
 protected:
  void SetUp() override {
    const auto* info = testing::UnitTest::GetInstance()->current_test_info();
    folder_ = std::filesystem::temp_directory_path() /
              (std::string("crease_obj_") + info->name() + std::to_string(std::random_device{}()));
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::filesystem::path write(const std::string& text) const {
    const std::filesystem::path file = folder_ / "cloth.obj";
    std::ofstream(file) << text;
    return file;
  }

  // What read_obj says about a text, without the folder's name.
  std::string complaint(const std::string& text) const {
    try {
      read_obj(write(text));
    } catch (const std::runtime_error& error) {
      const std::string what = error.what(), prefix = folder_.string() + "/";
      return what.starts_with(prefix) ? what.substr(prefix.size()) : what;
    }
    return "nothing";
  }

  std::filesystem::path folder_;
};

constexpr char square[] =
    "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"
    "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n";

std::string to_text(const Cloth& cloth, double time = 0) {
  std::ostringstream out;
  const NamedCloth named{"sheet", &cloth};
  write_obj(out, std::span(&named, 1), time);
  return out.str();
}

TEST_F(ObjFile, RoundTripKeepsEveryBit) {
  const std::uint64_t seed = 7;
  SCOPED_TRACE(seed);
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> noise(-1e-3, 1e-3);
  GridOptions options;
  options.cells = {5, 4};
  Cloth cloth = make_cloth(make_grid(options));
  for (Vec3& x : cloth.mesh.x) x += Vec3(noise(random), noise(random), 1e17 * noise(random));
  for (Vec2& X : cloth.mesh.X) X += Vec2(noise(random), noise(random));
  cloth.mesh.x[0].z() = 5e-324;  // the smallest double
  cloth.mesh.x[1].z() = -0.0;

  const Mesh read = read_obj(write(to_text(cloth)));
  ASSERT_EQ(read.n_vertices(), cloth.mesh.n_vertices());
  ASSERT_EQ(read.n_faces(), cloth.mesh.n_faces());
  for (int i = 0; i < read.n_vertices(); ++i) {
    for (int k = 0; k < 3; ++k)
      EXPECT_EQ(std::bit_cast<std::uint64_t>(read.x[i][k]), std::bit_cast<std::uint64_t>(cloth.mesh.x[i][k]));
    for (int k = 0; k < 2; ++k)
      EXPECT_EQ(std::bit_cast<std::uint64_t>(read.X[i][k]), std::bit_cast<std::uint64_t>(cloth.mesh.X[i][k]));
  }
  for (int f = 0; f < read.n_faces(); ++f) EXPECT_EQ(read.face(f), cloth.mesh.face(f));
  EXPECT_EQ(to_text(make_cloth(read)), to_text(cloth));
}

TEST_F(ObjFile, HeaderGivesTimeAndEolVerticesCountedFromOne) {
  Cloth cloth = make_cloth(make_grid({}));
  cloth.feature[0] = {0, FeatureKind::Edge, 3};
  cloth.feature[4] = {0, FeatureKind::Corner, 1};
  EXPECT_TRUE(to_text(cloth, 0.1).starts_with("# time 0.1\n# eol 1 5\nv "));
}

TEST_F(ObjFile, SeveralClothsAreNamedAndNumberedOn) {
  GridOptions one_cell;
  one_cell.cells = {1, 1};
  one_cell.pattern = GridPattern::Right;
  Cloth first = make_cloth(make_grid(one_cell)), second = first;
  second.feature[1] = {0, FeatureKind::Edge, 0};
  const std::vector<NamedCloth> named{{"left", &first}, {"right", &second}};
  std::ostringstream out;
  write_obj(out, named, 1);
  const std::string text = out.str();
  EXPECT_NE(text.find("# eol 6\n"), std::string::npos) << text;
  EXPECT_NE(text.find("o left\n"), std::string::npos);
  EXPECT_NE(text.find("o right\n"), std::string::npos);
  EXPECT_EQ(read_obj(write(text)).n_vertices(), 8);
}

TEST_F(ObjFile, RefusesAClothWithRemovedSlots) {
  Cloth cloth = make_cloth(make_grid({}));
  for (const int h : cloth.mesh.edges())
    if (cloth.mesh.can_collapse(h)) {
      cloth.mesh.collapse(h);
      break;
    }
  ASSERT_FALSE(cloth.mesh.is_compact());
  EXPECT_THROW(to_text(cloth), std::invalid_argument);
}

TEST_F(ObjFile, ReadsWhatOtherProgramsWrite) {
  // Names, normals, groups, materials, Windows line ends, a third texture coordinate, numbers from the end.
  const Mesh mesh = read_obj(
      write("# made elsewhere\r\nmtllib a.mtl\r\no sheet\r\n"
            "v 0 0 1e0\r\nv +1 0 1\r\nv 1 1 1 1.0\r\nv 0 1 1\r\n"
            "vt 0 0 0\r\nvt 1 0\r\nvt 1 1\r\nvt 0 1\r\nvn 0 0 1\r\n"
            "usemtl cloth\r\ns off\r\ng all\r\nf 1/1/1 2/2/1 3/3/1 # a comment\r\n\r\nf -4/-4 -2/-2 -1/-1\r\n"));
  EXPECT_EQ(mesh.n_faces(), 2);
  EXPECT_EQ(mesh.face(1), (std::array{0, 2, 3}));
  EXPECT_EQ(mesh.x[1], Vec3(1, 0, 1));
}

TEST_F(ObjFile, TextureNumbersMayDifferFromVertexNumbers) {
  const Mesh mesh = read_obj(write("v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 2\nvt 0 0\nvt 2 0\nf 1/2 2/3 3/1\n"));
  EXPECT_EQ(mesh.X[0], Vec2(0, 0));
  EXPECT_EQ(mesh.X[1], Vec2(2, 0));
  EXPECT_EQ(mesh.X[2], Vec2(0, 2));
}

TEST_F(ObjFile, SameTextureCoordinateUnderTwoNumbersIsNoSeam) {
  const std::string text = std::string(square) + "vt 0 0\nf 1/1 2/2 3/3\nf 1/5 3/3 4/4\n";
  EXPECT_EQ(read_obj(write(text)).n_faces(), 2);
}

TEST_F(ObjFile, AnEdgeWithOtherTextureCoordinatesOnEachSideIsASeam) {
  // The upper triangle lies elsewhere in material space; v 1 and 3 are its two ends on the seam.
  const Mesh mesh = read_obj(write(std::string(square) + "vt 5 5\nvt 6 6\nvt 5 6\nf 1/1 2/2 3/3\nf 1/5 3/6 4/7\n"));
  ASSERT_EQ(mesh.validate(), std::nullopt);
  EXPECT_EQ(mesh.n_vertices(), 6);
  EXPECT_EQ(mesh.face(0), (std::array{0, 1, 2}));
  EXPECT_EQ(mesh.face(1), (std::array{4, 5, 3}));
  EXPECT_TRUE(mesh.are_tied(0, 4) && mesh.are_tied(2, 5) && !mesh.is_tied(1) && !mesh.is_tied(3));
  EXPECT_EQ(mesh.X[4], Vec2(5, 5));
  EXPECT_EQ(mesh.x[4], mesh.x[0]);
  EXPECT_NE(mesh.seam_twin(2), Mesh::none);
}

TEST_F(ObjFile, ASeamMayBeginWhereBothSidesHaveTheSameTextureCoordinate) {
  // Inside a sheet that is one vertex, on its border it is two: no triangle joins them.
  const Mesh mesh = read_obj(write(std::string(square) + "vt 2 1\nvt 1 2\nf 1/1 2/2 3/3\nf 1/1 3/5 4/6\n"));
  ASSERT_EQ(mesh.validate(), std::nullopt);
  EXPECT_EQ(mesh.n_vertices(), 6);
  EXPECT_TRUE(mesh.are_tied(0, mesh.face(1)[0]) && mesh.face(1)[0] != 0);
}

// Numbers and all: a sewn cloth that was read is written as it stood in the file.
TEST_F(ObjFile, RoundTripKeepsSeams) {
  for (const auto& [name, start] : support::sewn_meshes()) {
    SCOPED_TRACE(name);
    const Mesh mesh = read_obj(write(to_text(make_cloth(start))));
    ASSERT_EQ(mesh.validate(), std::nullopt);
    ASSERT_EQ(mesh.n_vertices(), start.n_vertices());
    EXPECT_EQ(support::border_length(mesh, true), support::border_length(start, true));
    EXPECT_EQ(support::border_length(mesh, false), support::border_length(start, false));
    EXPECT_EQ(to_text(make_cloth(read_obj(write(to_text(make_cloth(mesh)))))), to_text(make_cloth(mesh)));
  }
}

TEST_F(ObjFile, NamesTheLineOfWhatIsWrong) {
  struct Case {
    std::string text, begins, says;
  };
  const std::string s = square;  // 8 lines
  const std::vector<Case> cases{
      {"v 0 0\n", "cloth.obj:1: ", "3 coordinates"},
      {"v 0 0 x\n", "cloth.obj:1: ", "finite number, got 'x'"},
      {"v 0 0 nan\n", "cloth.obj:1: ", "finite number, got 'nan'"},
      {"v 0 0 1e999\n", "cloth.obj:1: ", "finite number, got '1e999'"},
      {"v 0 0 1,5\n", "cloth.obj:1: ", "finite number, got '1,5'"},
      {"v 0 0 0\nvt 1\n", "cloth.obj:2: ", "2 numbers"},
      {"v 0 0 0\nface 1 2 3\n", "cloth.obj:2: ", "unknown statement 'face'"},
      {s + "f 1/1 2/2 3/3 4/4\n", "cloth.obj:9: ", "only triangles"},
      {s + "f 1/1 2/2\n", "cloth.obj:9: ", "only triangles"},
      {s + "f 1 2 3\n", "cloth.obj:9: ", "no texture coordinate"},
      {s + "f 1//1 2//1 3//1\n", "cloth.obj:9: ", "no texture coordinate"},
      {s + "f 1/1 2/2 0/3\n", "cloth.obj:9: ", "expected the number of a vertex"},
      {s + "f 1/1 2/2 x/3\n", "cloth.obj:9: ", "expected the number of a vertex"},
      {s + "f 1/1 2/2 9/3\n", "cloth.obj:9: ", "vertex 9 does not exist"},
      {s + "f 1/1 2/2 3/9\n", "cloth.obj:9: ", "texture coordinate 9 does not exist"},
      {s + "f -9/1 2/2 3/3\n", "cloth.obj:9: ", "does not exist"},
      {s + "f 1/1 2/2 2/3\n", "cloth.obj:9: ", "stands twice"},
      {s + "f 1/1 2/2 3/3\nf 1/1 3/3 4/4\nv .5 .5 1\nvt .1 3\nvt .9 3\nvt .5 4\nf 1/5 3/6 5/7\n",
       "cloth.obj:15: ", "not manifold"},
      {s + "f 1/1 2/2 3/3\n", "cloth.obj:4: ", "vertex 4 is in no triangle"},
      {s + "f 1/1 2/2 3/3\nf 1/1 4/4 3/3\n", "cloth.obj:10: ", "inverted"},
      {s + "v 2 0 0\nvt 2 0\nf 1/1 2/2 3/3\nf 1/1 3/3 4/4\nf 1/1 2/2 5/5\n", "cloth.obj:13: ", "zero area"},
      {s + "v 3 3 3\nvt .5 .4\nf 1/1 2/2 3/3\nf 1/1 3/3 4/4\nf 1/1 2/2 5/5\n", "cloth.obj:13: ", "not manifold"},
      {s + "v 2 1 0\nv 2 2 0\nvt 2 1\nvt 2 2\nf 1/1 2/2 3/3\nf 1/1 3/3 4/4\nf 3/3 5/5 6/6\n", "cloth.obj:1",
       "two pieces"},
      {"", "cloth.obj:1: ", "no faces"},
      {s, "cloth.obj:8: ", "no faces"},
  };
  for (const auto& [text, begins, says] : cases) {
    const std::string what = complaint(text);
    EXPECT_TRUE(what.starts_with(begins)) << text << "-> " << what;
    EXPECT_NE(what.find(says), std::string::npos) << text << "-> " << what;
  }
}

TEST_F(ObjFile, ThreePointsOnALineHaveNoAreaWhateverRoundingSays) {
  // 0.1 + 0.2 != 0.3: the cross product of these is 3e-17 and not 0.
  const std::string text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 0.1 0.3\nvt 0.30000000000000004 0.9\nf 1/1 2/2 3/3\n";
  EXPECT_NE(complaint(text).find("zero area"), std::string::npos) << complaint(text);
}

TEST_F(ObjFile, SaysWhyAFileCannotBeRead) {
  const auto what = [](const std::filesystem::path& file) -> std::string {
    try {
      read_obj(file);
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "nothing";
  };
  EXPECT_NE(what(folder_ / "none.obj").find("No such file"), std::string::npos);
  EXPECT_NE(what(folder_).find("directory"), std::string::npos);
}

}  // namespace
}  // namespace crease
