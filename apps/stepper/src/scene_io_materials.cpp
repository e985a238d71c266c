// SPDX-License-Identifier: MIT
#include <array>

#include <nlohmann/json.hpp>

#include "crease/stepper/suggest.hpp"
#include "scene_io_parts.hpp"

namespace crease {
namespace {

struct ShippedMaterial {
  const char* name;
  Material material;
};

// Densities are measured [WANG11] (samples
// "gray-interlock", 60 % cotton 40 % polyester, t-shirt; "11oz-black-denim", 99 % cotton, jeans; "white-dots-on-blk",
// polyester, tablecloth). The stiffnesses are this project's own round numbers of the order that such cloth has: soft
// in the plane as a knit or firm as a weave, bending as in fabric hand tests (1e-6 to 1e-4 N m).
constexpr std::array<ShippedMaterial, 3> shipped_materials{{
    {"cotton", {0.187, 400, 0.3, 4e-6, 0}},
    {"denim", {0.324, 4000, 0.2, 5e-5, 0}},
    {"polyester", {0.128, 1500, 0.3, 8e-6, 0}},
}};

}  // namespace

void expand_materials(Json& document, ProblemList& problems) {
  if (!document.is_object() || !document.contains("cloths") || !document["cloths"].is_array()) return;
  Json& cloths = document["cloths"];
  std::vector<std::string> names;
  for (const ShippedMaterial& shipped : shipped_materials) names.emplace_back(shipped.name);
  for (size_t i = 0; i < cloths.size(); ++i) {
    if (!cloths[i].is_object() || !cloths[i].contains("material") || !cloths[i]["material"].is_string()) continue;
    Json& value = cloths[i]["material"];
    const std::string name = value;
    bool found = false;
    for (const auto& [shipped, m] : shipped_materials) {
      if (name != shipped) continue;
      found = true;
      value = {{"density", m.density},
               {"youngs", m.youngs},
               {"poisson", m.poisson},
               {"bending", m.bending},
               {"damping", m.damping}};
      break;
    }
    const std::string pointer = "/cloths/" + std::to_string(i) + "/material";
    if (!found && !problems.at(pointer))
      problems.add(pointer, "\"" + name + "\" is no shipped material" + suggestion(name, names));
  }
}

}  // namespace crease
