#include "planegraph/base/heartbeat.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <vector>

namespace planegraph {
namespace {

using std::chrono::milliseconds;
using testing::Each;
using testing::SizeIs;
using testing::StartsWith;

constexpr milliseconds kInterval{20};

struct Said {
  std::vector<std::string> lines;
  std::vector<Heartbeat::Clock::time_point> times;

  std::function<void(const std::string&)> Recorder() {
    return [this](const std::string& line) {
      lines.push_back(line);
      times.push_back(Heartbeat::Clock::now());
    };
  }
  void ExpectApart() const {
    for (std::size_t k = 1; k < times.size(); ++k) {
      EXPECT_GE(times[k] - times[k - 1], kInterval - milliseconds(1));
    }
  }
};

TEST(Heartbeat, SilentWorkShowsThatItLives) {
  Said said;
  {
    Heartbeat heartbeat(kInterval, said.Recorder());
    std::this_thread::sleep_for(10 * kInterval);
  }
  EXPECT_GE(said.lines.size(), 2u);  // a busy machine may beat late
  EXPECT_THAT(said.lines, Each(StartsWith("at work, 0 s")));
  said.ExpectApart();
}

TEST(Heartbeat, NamesTheStage) {
  Said said;
  {
    Heartbeat heartbeat(kInterval, said.Recorder());
    heartbeat.Report("registration", 0.507);
    std::this_thread::sleep_for(10 * kInterval);
  }
  EXPECT_GE(said.lines.size(), 2u);
  EXPECT_THAT(said.lines, Each(StartsWith("registration 50 %")));
}

TEST(Heartbeat, ManyReportsAreFewLines) {
  Said said;
  const auto start = Heartbeat::Clock::now();
  {
    Heartbeat heartbeat(kInterval, said.Recorder());
    const auto report = [&](int from) {
      for (int k = from; k < from + 2000; ++k) heartbeat.Report("scans", k / 4000.0);
    };
    std::thread other(report, 0);
    report(2000);
    other.join();
  }
  EXPECT_LE(said.lines.size(), (Heartbeat::Clock::now() - start) / kInterval);
  said.ExpectApart();
}

TEST(Heartbeat, ShortWorkSaysNothing) {
  Said said;
  {
    Heartbeat heartbeat(std::chrono::hours(1), said.Recorder());
    for (int k = 0; k < 1000; ++k) heartbeat.Report("scans", k / 1000.0);
  }
  EXPECT_THAT(said.lines, SizeIs(0));
}

}  // namespace
}  // namespace planegraph
