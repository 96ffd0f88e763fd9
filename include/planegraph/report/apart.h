#pragma once

#include <string>
#include <vector>

namespace planegraph {

/// A scan by its name ROBOT/NNN and the number of its component.
struct ComponentScan {
  std::string id;
  int component = 0;
};

/// The component with most scans, which is the map; of equal ones the lowest number. -1 where there
/// are no scans.
int MainComponent(const std::vector<ComponentScan>& scans);

/// Who is not in the main component: "cart/004 | cart/005 to 007, ugv/001 stand apart". Components
/// are parted by bars; of many the first few are named. Empty where there is one component.
std::string ApartText(const std::vector<ComponentScan>& scans);

}  // namespace planegraph
