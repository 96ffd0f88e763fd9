#include "report/html.h"

#include <gtest/gtest.h>

#include <limits>

#include "report/html_checker.h"

namespace planegraph {
namespace {

TEST(Html, EscapesWhatMeansSomething) {
  EXPECT_EQ(Escape("a<b>&\"c'"), "a&lt;b&gt;&amp;&quot;c&#39;");
  EXPECT_EQ(Escape("Größe 3 m"), "Größe 3 m");
}

TEST(Html, NumbersAreRoundedAndNeverNegativeZero) {
  EXPECT_EQ(Fixed(1.005, 1), "1.0");
  EXPECT_EQ(Fixed(-0.04, 1), "0.0");
  EXPECT_EQ(Fixed(-0.06, 1), "-0.1");
  EXPECT_EQ(Fixed(std::numeric_limits<double>::infinity(), 1), "∞");
  EXPECT_EQ(FixedOrDash(std::nullopt, 1), kDash);
  EXPECT_EQ(FixedOrDash(0.0123, 1, 1000.0), "12.3");
}

TEST(Html, SignificantDigits) {
  EXPECT_EQ(Significant(0.0, 3), "0");
  EXPECT_EQ(Significant(std::numeric_limits<double>::infinity(), 3), "∞");
  EXPECT_EQ(Significant(1234.6, 2), "1235");  // no digit before the point is dropped
  EXPECT_EQ(Significant(0.01234, 2), "0.012");
  EXPECT_EQ(Significant(1.5e-9, 2), "1.5e-09");
}

TEST(Html, GroupsDigits) {
  EXPECT_EQ(Grouped(7), "7");
  EXPECT_EQ(Grouped(999), "999");
  EXPECT_EQ(Grouped(1234567), "1\u202f234\u202f567");
  EXPECT_EQ(Grouped(-123456), "-123\u202f456");
}

TEST(Html, TableShowsDashesForMissingCellsAndFoldsUp) {
  HtmlTable table({{"id", "", false}, {"size", "m"}});
  table.Row({"a"});
  const std::string open = table.Html("all", 1);
  EXPECT_NE(open.find("<td>a</td><td class=\"n\">–</td>"), std::string::npos);
  EXPECT_EQ(open.find("<details>"), std::string::npos);
  table.Row({"b", "2"});
  const std::string folded = table.Html("all", 1);
  EXPECT_NE(folded.find("<details>"), std::string::npos);
  EXPECT_EQ(FirstFault(folded), "");
}

TEST(Html, NothingGivesNothing) {
  EXPECT_EQ(HtmlTable({{"id", "", false}}).Html("all"), "");
  EXPECT_EQ(Section("Title", ""), "");
}

TEST(HtmlCheckerTest, FindsFaults) {
  EXPECT_EQ(FirstFault("<p>a<br>b</p>"), "");
  EXPECT_NE(FirstFault("<p>a"), "");
  EXPECT_NE(FirstFault("<p><b></p></b>"), "");
  EXPECT_NE(FirstFault("<p>1 < 2</p>"), "");
  EXPECT_NE(FirstFault("<p class=\"a>b</p>"), "");
}

}  // namespace
}  // namespace planegraph
