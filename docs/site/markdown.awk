# Markdown as GitHub shows it to Markdown as Doxygen 1.9 links it: a page and its headings get names (a page that of its
# file, a heading as on GitHub behind that), and links to pages and headings use them. In docs/index.md a list item that
# starts with a link makes that page a child in the tree. Code stays as it is.
function page_of(path) {
  sub(/.*\//, "", path)
  sub(/\.md$/, "", path)
  return tolower(path)
}

function slug_of(heading) {
  heading = tolower(heading)
  gsub(/\[|\]\([^)]*\)/, "", heading)
  gsub(/[^a-z0-9 _-]/, "", heading)
  gsub(/ /, "-", heading)
  return heading
}

function name_of(level, slug) {
  if (level == "#") return page == "index" ? "mainpage" : page
  seen[slug]++
  return page "-" slug (seen[slug] > 1 ? "-" seen[slug] - 1 : "")
}

# The name that a link's target has on the site; empty where it is no page of it.
function target_of(link, parts) {
  if (link ~ /^#/) return page "-" substr(link, 2)
  if (link ~ /:\/\// || link !~ /\.md(#.*)?$/) return ""
  split(link, parts, "#")
  if (parts[1] ~ /third_party\//) parts[1] = "third_party"
  return page_of(parts[1]) (parts[2] == "" ? "" : "-" parts[2])
}

function with_links(text, done, link, words, target) {
  done = ""
  while (match(text, /\[[^][]*\]\([^() ]+\)/)) {
    link = substr(text, RSTART, RLENGTH)
    words = substr(link, 2, index(link, "](") - 2)
    target = target_of(substr(link, index(link, "](") + 2, length(link) - index(link, "](") - 2))
    if (target != "") {
      gsub(/`/, "", words)
      command = page == "index" && done substr(text, 1, RSTART - 1) ~ /^- $/ ? "\\subpage " : "\\ref "
      link = command target " \"" words "\""
    }
    done = done substr(text, 1, RSTART - 1) link
    text = substr(text, RSTART + RLENGTH)
  }
  return done text
}

FNR == 1 { page = page_of(FILENAME) }
FILENAME ~ /third_party/ { page = "third_party" }
/^ *```/ { code = !code; print; next }
code { print; next }
/^#+ / {
  heading = $0
  sub(/^#+ /, "", heading)
  level = $0
  sub(/ .*/, "", level)
  text = with_links($0)
  gsub(/`/, "", text)  # Doxygen shows marks of code in headings as they are
  print text " {#" name_of(level, slug_of(heading)) "}"
  next
}
{ print with_links($0) }
