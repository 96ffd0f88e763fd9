#include "planegraph/report/apart.h"

#include <map>

namespace planegraph {
namespace {

using Members = std::map<int, std::vector<std::size_t>>;

Members MembersOf(const std::vector<ComponentScan>& scans) {
  Members members;
  for (std::size_t i = 0; i < scans.size(); ++i) members[scans[i].component].push_back(i);
  return members;
}

std::string RobotOf(const std::string& id) { return id.substr(0, id.rfind('/') + 1); }

// Scans that follow each other are one run: "cart/005 to 007, ugv/001".
std::string RunsText(const std::vector<ComponentScan>& scans,
                     const std::vector<std::size_t>& members) {
  constexpr int kMostRuns = 3;
  std::string text;
  int runs = 0;
  for (std::size_t k = 0; k < members.size();) {
    const std::string& first = scans[members[k]].id;
    std::size_t end = k + 1;
    while (end < members.size() && members[end] == members[end - 1] + 1 &&
           RobotOf(scans[members[end]].id) == RobotOf(first)) {
      ++end;
    }
    if (runs++ == kMostRuns) return text + ", ...";
    const std::string& last = scans[members[end - 1]].id;
    text += (text.empty() ? "" : ", ") + first;
    if (end > k + 1) text += " to " + last.substr(last.rfind('/') + 1);
    k = end;
  }
  return text;
}

}  // namespace

int MainComponent(const std::vector<ComponentScan>& scans) {
  int main = -1;
  std::size_t most = 0;
  for (const auto& [component, members] : MembersOf(scans)) {
    if (members.size() > most) most = members.size(), main = component;
  }
  return main;
}

std::string ApartText(const std::vector<ComponentScan>& scans) {
  constexpr std::size_t kMostNamed = 5;
  Members members = MembersOf(scans);
  const auto main = members.find(MainComponent(scans));
  if (members.size() < 2) return "";
  const bool single = scans.size() - main->second.size() == 1;
  members.erase(main);
  std::string text;
  std::size_t named = 0;
  for (const auto& [component, apart] : members) {
    if (named++ == kMostNamed) {
      text += " | ...";
      break;
    }
    text += (text.empty() ? "" : " | ") + RunsText(scans, apart);
  }
  return text + (single ? " stands apart" : " stand apart");
}

}  // namespace planegraph
