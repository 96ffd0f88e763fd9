#include "planegraph/simulation/mesh_parts.h"
#include "simulation/scenes.h"

namespace planegraph {

// Everything is a prism along x, and the ends lie out of the sensor's range: no scan says where
// along the corridor it was taken.
Scene BuildCorridor(Random* random, double max_range) {
  const double drive = random->Uniform(20.0, 24.0), margin = max_range + 2.0;
  const double left = random->Uniform(1.1, 1.4), right = -random->Uniform(1.1, 1.4);
  const double height = random->Uniform(2.6, 3.2), slab = 0.25;
  MeshBuilder builder;
  const auto prism = [&](double y0, double y1, double z0, double z1) {
    AddBox(&builder, Rigid3(), {-margin, y0, z0}, {drive + margin, y1, z1});
  };
  prism(right - slab, left + slab, -slab, 0.0);
  prism(right - slab, left + slab, height, height + slab);
  prism(left, left + slab, 0.0, height);
  prism(right - slab, right, 0.0, height);
  // An air duct under the ceiling.
  const double width = random->Uniform(0.4, 0.6), depth = random->Uniform(0.3, 0.5);
  prism(left - width, left, height - depth, height);
  Scene scene;
  scene.mesh = builder.mesh();
  scene.drives = {{"robot1", {{0.0, 0.1}, {drive, -0.1}}, 8}};
  scene.area_low = {0.0, -6.0};
  scene.area_high = {drive, 6.0};
  return scene;
}

}  // namespace planegraph
