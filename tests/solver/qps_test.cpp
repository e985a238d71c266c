// SPDX-License-Identifier: MIT
#include "crease/solver/qps.hpp"

#include <gtest/gtest.h>

#include <sstream>
#include <string>

#include "crease/solver/qp_solver.hpp"
#include "support/qp_problems.hpp"

namespace crease {
namespace {

using support::objective;
using support::Random;

QpProblem read_text(const std::string& text) {
  std::istringstream in(text);
  return read_qps(in);
}

/// Published problems, typed from their formulas, each in another dialect of the format [HOCK81, Nos. 21, 35 and 76].
///
/// 21: .01 x^2 + y^2 (- 100),  10 x - y >= 10,  2 <= x <= 50,  -50 <= y <= 50: x = (2, 0), objective .04.
constexpr const char* hs21 = R"(* a comment
NAME          HS21
ROWS
 N  OBJ
 G  R1
COLUMNS
    X         R1        .1E+02
    Y         R1        -.1E+01
RHS
    RHS       OBJ       .1E+03   R1  .1E+02
BOUNDS
 LO BNDS      X         2
 UP BNDS      X         50
 LO BNDS      Y         -50
 UP BNDS      Y         50
QUADOBJ
    X         X         .2E-01
    Y         Y         2
ENDATA
)";

/// 35: 2 x^2 + 2 y^2 + z^2 + 2 x y + 2 x z - 8 x - 6 y - 4 z (+ 9),  x + y + 2 z <= 3,  x, y, z >= 0: objective 1/9
/// - 9.
constexpr const char* hs35 = R"(NAME HS35
ROWS
 N obj
 L sum
COLUMNS
 x obj -8 sum 1
 y obj -6 sum 1
 z obj -4
 z sum 2
RHS
 sum 3
QMATRIX
 x x 4
 x y 2
 x z 2
 y x 2
 y y 4
 z x 2
 z z 2
ENDATA
)";

/// 76: x^2 + y^2/2 + z^2 + w^2/2 - x z + z w - x - 3 y + z - w,  x + 2 y + z + w <= 5,  3 x + y + 2 z - w <= 4,
/// y + 4 z >= 1.5, all >= 0: objective -103/22 = -4.68181818.
constexpr const char* hs76 = R"(NAME HS76
ROWS
 N obj
 L c1
 L c2
 G c3
 N unused
COLUMNS
 x obj -1 c1 1
 x c2 3 unused 7
 y obj -3 c1 2
 y c2 1 c3 1
 z obj 1 c1 1
 z c2 2 c3 4
 w obj -1 c1 1
 w c2 -1
RHS
 RHS c1 5 c2 4
 RHS c3 1.5
BOUNDS
 PL BND x
QUADOBJ
 x x 2
 x z -1
 y y 1
 z z 2
 z w 1
 w w 1
ENDATA
)";

TEST(Qps, ReadsPublishedProblemsWhoseMinimaAreKnown) {
  const struct {
    const char *name, *text;
    double objective;
  } cases[] = {{"HS21", hs21, 0.04}, {"HS35", hs35, 1.0 / 9 - 9}, {"HS76", hs76, -103.0 / 22}};
  for (const auto& [name, text, expected] : cases)
    for (const QpMethod method : {QpMethod::ActiveSet, QpMethod::InteriorPoint, QpMethod::Ipopt}) {
      const QpProblem problem = read_text(text);
      const QpResult result = make_qp_solver(method)->solve(problem);
      ASSERT_EQ(result.status, QpStatus::Solved) << name << ": " << result.message;
      EXPECT_NEAR(objective(problem, result.q), expected, 1e-7) << name;  // the residual's tolerance is 1e-8
    }
}

TEST(Qps, WhatIsReadBackIsTheSame) {
  Random random(7);
  for (int round = 0; round < 20; ++round) {
    QpProblem problem = support::random_dense(random, random.integer(1, 9), random.integer(0, 1), random.integer(0, 6));
    const auto n = static_cast<int>(problem.f.size());
    for (int start = 0; start < n; start += random.integer(1, 3)) problem.blocks.push_back(start);
    if (round % 2 == 0)
      problem.blocks.push_back(n);
    else
      problem.blocks.clear();
    std::stringstream file;
    write_qps(file, problem, "random");
    const QpProblem read = read_qps(file);
    EXPECT_EQ(MatX(read.H), MatX(problem.H));
    EXPECT_EQ(read.H.nonZeros(), problem.H.nonZeros());
    EXPECT_EQ(read.f, problem.f);
    EXPECT_EQ(MatX(read.A_eq), MatX(problem.A_eq));
    EXPECT_EQ(MatX(read.A_in), MatX(problem.A_in));
    EXPECT_EQ(read.b_eq, problem.b_eq);
    EXPECT_EQ(read.b_in, problem.b_in);
    EXPECT_EQ(read.blocks, problem.blocks);
  }
}

TEST(Qps, EveryKindOfBoundBecomesRows) {
  const QpProblem problem = read_text(
      "NAME b\nROWS\n N obj\nCOLUMNS\n x0 obj 1\n x1 obj 1\n x2 obj 1\n x3 obj 1\n x4 obj 1\nBOUNDS\n FR BND x0\n MI "
      "x1\n "
      "UP BND x1 -2\n FX BND x2 3\n LO x3 -4\nENDATA\n");
  const MatX expected = (MatX(5, 5) << 0, -1, 0, 0, 0,  // x1 <= -2
                         0, 0, 1, 0, 0,                 // x2 >= 3
                         0, 0, -1, 0, 0,                // x2 <= 3
                         0, 0, 0, 1, 0,                 // x3 >= -4
                         0, 0, 0, 0, 1)                 // x4 >= 0, told by nobody
                            .finished();
  EXPECT_EQ(MatX(problem.A_in), expected);
  EXPECT_EQ(problem.b_in, (VecX(5) << 2, 3, -3, -4, 0).finished());
}

TEST(Qps, WhatIsWrongIsToldWithItsLine) {
  const std::string head = "NAME b\nROWS\n N obj\n G r\nCOLUMNS\n x obj 1 r 1\n";
  const struct {
    const char *text, *message;
  } cases[] = {{"", "line 6: the file ends without ENDATA"},
               {" x q 1\n", "line 7: there is no row 'q'"},
               {" x obj 1e999\n", "line 7: '1e999' is not a finite number"},
               {" x obj 1 r\n", "line 7: a column, and a row and a number once or twice, were expected"},
               {" MARK 'MARKER' 'INTORG'\n", "line 7: integers are not supported"},
               {"RANGES\n", "line 7: section 'RANGES' is not supported"},
               {"RHS\n RHS r 1 obj 2 x 3\n", "line 8: a name and a number, once or twice, were expected"},
               {"BOUNDS\n BV BND x\n", "line 8: bound 'BV' is not supported"},
               {"BOUNDS\n UP BND x -1\n", "line 8: an upper bound below 0 needs a lower one"},
               {"BOUNDS\n LO 1\n", "line 8: a bound's type, column and number were expected"},
               {"QUADOBJ\n x y 1\n", "line 8: there is no column 'y'"},
               {"QUADOBJ\n x x\n", "line 8: two columns and a number were expected"},
               {"* blocks 0 q\n", "line 7: 'q' is not a block's start"},
               {"* blocks 0 5\nENDATA\n", "line 8: "}};
  for (const auto& [text, message] : cases) {
    try {
      read_text(head + text);
      ADD_FAILURE() << "accepted: " << text;
    } catch (const std::runtime_error& error) {
      EXPECT_NE(std::string(error.what()).find(message), std::string::npos) << error.what();
    }
  }
  EXPECT_THROW(read_text("ROWS\n N obj\n N obj\n"), std::runtime_error);
  EXPECT_THROW(read_text(" x y\n"), std::runtime_error);
}

}  // namespace
}  // namespace crease
