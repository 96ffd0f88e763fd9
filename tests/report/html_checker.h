#pragma once

#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace planegraph {

/// The first fault of a page as far as tags are concerned: one that is not closed, or closed by
/// another; an attribute without quotes; a bare `<`. Empty where there is none.
class HtmlChecker {
 public:
  explicit HtmlChecker(std::string_view page) : page_(page) {}

  std::string Fault() {
    while (fault_.empty() && NextTag()) {
    }
    if (fault_.empty() && !open_.empty()) fault_ = "not closed: " + open_.back();
    return fault_;
  }
  std::size_t tags() const { return tags_; }

 private:
  bool NextTag() {
    const std::size_t start = page_.find('<', at_);
    if (start == std::string_view::npos) return false;
    const std::size_t end = TagEnd(start);
    if (end == std::string_view::npos) return Fail("no end of tag at " + std::to_string(start));
    Handle(page_.substr(start + 1, end - start - 1));
    at_ = end + 1;
    if (fault_.empty() && !open_.empty() && open_.back() == "style") SkipStyle();
    return true;
  }

  // The `>` that no quotes hold.
  std::size_t TagEnd(std::size_t start) const {
    bool quoted = false;
    for (std::size_t i = start + 1; i < page_.size(); ++i) {
      if (page_[i] == '"') quoted = !quoted;
      if (!quoted && page_[i] == '<') return std::string_view::npos;
      if (!quoted && page_[i] == '>') return i;
    }
    return std::string_view::npos;
  }

  void Handle(std::string_view tag) {
    ++tags_;
    if (tag.starts_with("!DOCTYPE")) return;
    const bool closes = tag.starts_with("/");
    const std::string name(
        tag.substr(closes ? 1 : 0, tag.find_first_of(" /", 1) - (closes ? 1 : 0)));
    if (name.empty() || !std::isalpha(static_cast<unsigned char>(name[0]))) {
      Fail("no tag: <" + std::string(tag) + ">");
    } else if (closes) {
      Close(std::string(tag.substr(1)));
    } else if (!tag.ends_with("/") && kVoid.count(name) == 0) {
      open_.push_back(name);
    }
  }

  void Close(const std::string& name) {
    if (open_.empty() || open_.back() != name) {
      Fail("</" + name + "> closes " + (open_.empty() ? "nothing" : open_.back()));
      return;
    }
    open_.pop_back();
  }

  void SkipStyle() { at_ = page_.find("</style>", at_); }

  bool Fail(const std::string& fault) {
    fault_ = fault;
    return false;
  }

  inline static const std::set<std::string> kVoid = {"meta", "br", "hr", "img", "link"};
  std::string_view page_;
  std::size_t at_ = 0, tags_ = 0;
  std::vector<std::string> open_;
  std::string fault_;
};

inline std::string FirstFault(const std::string& page) { return HtmlChecker(page).Fault(); }

}  // namespace planegraph
