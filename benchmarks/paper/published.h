#pragma once

#include <array>

namespace planegraph {

// The figures of Surmann, Berninger and Worst, "3D mapping for multi hybrid robot cooperation",
// tables I to V: another site, another scanner and another machine. For orientation only.

struct PublishedSegmentation {
  int points;
  double preprocessing, segmentation;  ///< seconds
  int planes;
};
struct PublishedRegistration {
  double seconds;
  int correspondences;
};
struct PublishedError {
  double rmse, min, max;  ///< metres
};

/// Table I, by scan.
inline constexpr std::array<PublishedSegmentation, 7> kPublishedLaser{
    {{103090, 0.0090, 0.1989, 8},
     {135233, 0.0096, 0.8091, 9},
     {182623, 0.0171, 1.2556, 11},
     {265629, 0.0175, 1.4302, 14},
     {286333, 0.0248, 2.5137, 19},
     {291043, 0.0197, 3.0201, 29},
     {289934, 0.0188, 2.8454, 24}}};
/// Table II, by pair of consecutive scans.
inline constexpr std::array<PublishedRegistration, 6> kPublishedPairs{
    {{0.0116, 2}, {0.3643, 8}, {0.0814, 7}, {2.3613, 18}, {4.6153, 15}, {7.7108, 17}}};
/// Table III, by the scan whose surroundings the section is.
inline constexpr std::array<PublishedSegmentation, 7> kPublishedSections{
    {{30745, 0.0035, 2.4906, 53},
     {49258, 0.0067, 6.9224, 109},
     {53586, 0.0079, 11.2961, 145},
     {48600, 0.0072, 10.2647, 149},
     {32366, 0.0055, 6.2082, 111},
     {28300, 0.0050, 6.4789, 108},
     {9754, 0.0028, 2.0793, 61}}};
/// Table IV, by scan.
inline constexpr std::array<PublishedRegistration, 7> kPublishedInMap{{{0.012568, 6},
                                                                       {0.2772, 7},
                                                                       {0.5608, 11},
                                                                       {0.4258, 9},
                                                                       {0.5098, 14},
                                                                       {1.3474, 20},
                                                                       {0.0896, 0}}};
/// Table V: pose tracking without global optimization.
inline constexpr PublishedError kPublishedRpe{3.3579, 0.2090, 8.1820};
inline constexpr PublishedError kPublishedAte{3.1074, 0.6780, 7.4754};

}  // namespace planegraph
