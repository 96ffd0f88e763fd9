#include "report/style.h"

namespace planegraph {

const char* const kReportStyle = R"css(
:root {
  color-scheme: light dark;
  --page: #ffffff; --card: #f5f6f8; --text: #1b2430; --quiet: #5b6675; --line: #d7dce2;
  --good: #1a7f4b; --fair: #9a6200; --bad: #b3261e; --grid: #00000014; --halo: #ffffff;
  --focus: #0b62c4;
  --upright: #141c28; --high: #6ba39d; --seen: #e2e5e8;
  --view: #f4f6f8;
}
.r0 { --robot: #0b6bcb; } .r1 { --robot: #d06a00; } .r2 { --robot: #8a3ffc; }
.r3 { --robot: #00857a; } .r4 { --robot: #c2255c; } .r5 { --robot: #6b7280; }
@media (prefers-color-scheme: dark) {
  :root {
    --page: #14181d; --card: #1e242b; --text: #e4e8ed; --quiet: #9aa6b3; --line: #343d47;
    --good: #5bc98d; --fair: #e0a63c; --bad: #f2867d; --focus: #6db3ff; --grid: #ffffff14; --halo: #14181d;
    --upright: #ebe3d7; --high: #5b948f; --seen: #2c3238;
    --view: #0d1014;
  }
  .map { filter: invert(1) hue-rotate(180deg); }
  .r0 { --robot: #4da3ff; } .r1 { --robot: #f0a050; } .r2 { --robot: #b794ff; }
  .r3 { --robot: #3cc9b8; } .r4 { --robot: #ff7ba5; } .r5 { --robot: #aab2bf; }
}
* { box-sizing: border-box; }
body {
  margin: 0 auto; padding: 1rem; max-width: 80rem; background: var(--page); color: var(--text);
  font: 16px/1.5 system-ui, "Segoe UI", Roboto, "Helvetica Neue", "DejaVu Sans", sans-serif;
  -webkit-text-size-adjust: 100%;
}
h1 { font-size: 1.8rem; line-height: 1.2; margin: 0 0 .6rem; overflow-wrap: anywhere; }
h2 { font-size: 1.2rem; margin: 2rem 0 .5rem; }
p { margin: .4rem 0; }
.brand, .note, footer { color: var(--quiet); font-size: .85rem; }
.verdict {
  display: flex; gap: .7rem; align-items: flex-start; padding: .7rem .9rem; margin: 0 0 .8rem;
  background: var(--card); border-left: 5px solid; border-radius: 6px; font-size: 1.05rem;
}
.verdict > span:last-child { color: var(--text); }
.verdict .sign { font-weight: 700; width: 1.2em; text-align: center; flex: none; }
.good { color: var(--good); } .fair { color: var(--fair); } .bad { color: var(--bad); }
.figures {
  display: grid; grid-template-columns: repeat(auto-fit, minmax(7.5rem, 1fr)); gap: .5rem;
}
.figures div { background: var(--card); border-radius: 6px; padding: .5rem .8rem; }
.figures b {
  display: block; font-size: 1.2rem; font-variant-numeric: tabular-nums; white-space: nowrap;
}
.figures span, .figures small { color: var(--quiet); font-size: .8rem; font-weight: 400; }
.scroll { overflow-x: auto; }
table { border-collapse: collapse; font-size: .85rem; font-variant-numeric: tabular-nums; width: 100%; }
th, td { padding: .3rem .55rem; text-align: left; vertical-align: top; }
td { border-top: 1px solid var(--line); }
td:not(:last-child) { white-space: nowrap; }
td:last-child:not(.n):not([colspan]) { min-width: 13rem; }
tr.more td { border-top: 0; padding-top: 0; color: var(--quiet); white-space: normal; overflow-wrap: anywhere; }
tr.more div { position: sticky; left: .55rem; max-width: min(75rem, calc(100vw - 3rem)); }
thead th { vertical-align: bottom; font-weight: 600; line-height: 1.25; }
th small { color: var(--quiet); font-weight: 400; }
.n { text-align: right; white-space: nowrap; } th.n { white-space: normal; }
tr.weak td:first-child { box-shadow: inset 3px 0 var(--fair); }
tr.unused td { color: var(--quiet); }
.facts { width: auto; } .facts th { border-top: 1px solid var(--line); font-weight: 400; color: var(--quiet); }
.facts td { white-space: normal; overflow-wrap: anywhere; }
code { font: .92em ui-monospace, "DejaVu Sans Mono", monospace; }
details > summary {
  cursor: pointer; padding: .45rem .8rem; background: var(--card); border-radius: 6px; margin: .4rem 0;
}
.pair { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(100%, 24rem), 1fr)); gap: 0 2rem; }
ul.words { padding-left: 1.2rem; margin: .3rem 0; }
ul.legend {
  list-style: none; display: flex; flex-wrap: wrap; gap: .25rem 1.2rem; padding: 0; margin: .4rem 0;
  font-size: .85rem; color: var(--quiet);
}
ul.legend li { display: flex; align-items: center; gap: .4rem; }
svg.key { width: 28px; height: 14px; flex: none; }
svg.plan { display: block; width: 100%; max-width: calc(var(--w) * 1px); height: auto; font-size: 12.5px; }
svg.plot { display: block; width: 100%; max-width: 640px; min-width: 20rem; height: auto; font-size: 12.5px; }
svg.bar { display: block; width: 100%; height: 1.6rem; border-radius: 4px; }
.grid { stroke: var(--grid); } .border { fill: none; stroke: var(--line); }
.tick { fill: var(--quiet); }
.label {
  fill: var(--text); font-weight: 600; paint-order: stroke; stroke: var(--halo); stroke-width: 3px;
  stroke-linejoin: round;
}
.halo { fill: none; stroke: var(--halo); stroke-width: 4; opacity: .8; }
path.bar { fill: none; stroke: var(--text); stroke-width: 1.6; }
.way { fill: none; stroke: var(--robot); stroke-width: 1.8; stroke-linejoin: round; }
.scan { fill: var(--robot); stroke: var(--halo); stroke-width: 1.4; }
.scan.apart { fill: var(--page); stroke: var(--robot); }
.way.apart { stroke-dasharray: 2 4; opacity: .7; }
.sigma { fill: var(--robot); fill-opacity: .2; stroke: var(--robot); stroke-width: 1; }
.open { stroke: #d1242f; stroke-width: 2; stroke-dasharray: 6 4; }
.photo { opacity: .55; } .photo-key { fill: #8f9a76; opacity: .7; }
.upright { fill: var(--upright); } .high { fill: var(--high); } .seen { fill: var(--seen); }
.edge { fill: none; stroke-width: 2; }
.e0 { stroke: #1a9850; } .e1 { stroke: #4f9bd9; } .e2 { stroke: #e08214; } .e3 { stroke: #d1242f; }
.em { stroke: #8a63d2; } .e9 { stroke: var(--quiet); }
.drone { fill: var(--page); stroke: var(--text); stroke-width: 2; }
.unused.edge { stroke: #9aa0a8; stroke-width: 1.3; stroke-dasharray: 3 4; }
.s0 { fill: #4f7cac; } .s1 { fill: #e0a458; } .s2 { fill: #6a994e; } .s3 { fill: #a06cd5; }
.s4 { fill: #c8553d; } .s5 { fill: #7d8491; } .s6 { fill: #c9ada7; }
.picture { height: min(70vh, 40rem); border-radius: 6px; overflow: hidden; background: var(--view); }
.picture canvas { display: block; width: 100%; height: 100%; cursor: grab; }
.picture canvas:active { cursor: grabbing; }
.picture canvas:focus-visible { outline: 2px solid var(--focus); outline-offset: -2px; }
#viewer[data-state="loading"]::before { content: "Loading the view…"; color: var(--quiet); }
.controls { display: flex; flex-wrap: wrap; gap: .4rem 1rem; align-items: center; margin: .4rem 0; font-size: .85rem; }
.controls label { display: flex; gap: .4rem; align-items: center; min-height: 2rem; }
.controls input[type="range"] { width: 8rem; } #viewer input { accent-color: var(--focus); }
#viewer button, #viewer select {
  font: inherit; font-size: .85rem; color: var(--text); background: var(--card);
  border: 1px solid var(--line); border-radius: 6px; padding: .3rem .7rem; min-height: 2rem;
}
#viewer button { cursor: pointer; }
.info { min-height: 2rem; font-size: .9rem; overflow-wrap: anywhere; }
.swatch { width: .9rem; height: .9rem; border-radius: 3px; } .swatch.wide { width: 8rem; }
button.show {
  font: inherit; color: var(--focus); background: none; border: 0; padding: 0; cursor: pointer;
  text-decoration: underline; text-underline-offset: 2px;
}
@media (max-width: 40rem) {
  .picture { height: 65vh; }
  body { padding: .7rem; } h1 { font-size: 1.45rem; }
  .figures { grid-template-columns: repeat(2, 1fr); }
  /* The whole plan on a small screen: its marks and texts shrink with it. */
  svg.plan { font-size: 19px; } svg.plan .label { font-size: 24px; } svg.plan .scan { r: 8px; }
  svg.plan .way, svg.plan .edge { vector-effect: non-scaling-stroke; }
}
@media print {
  :root {
    color-scheme: light; --page: #fff; --card: #f5f6f8; --text: #000; --quiet: #444;
    --line: #bbb; --grid: #00000014; --halo: #fff; --upright: #141c28; --high: #6ba39d;
    --seen: #e2e5e8; --good: #1a7f4b; --fair: #9a6200; --bad: #b3261e;
  }
  .controls, #viewer .note, .info button { display: none; }
  section:has(> #viewer:not([data-state="ready"])) { display: none; }  /* nothing was drawn */
  button.show { color: inherit; text-decoration: none; }
  .map { filter: none; } .r0 { --robot: #0b6bcb; } .r1 { --robot: #d06a00; }
  body { max-width: none; padding: 0; font-size: 10pt; }
  h2 { break-after: avoid; } svg.plan { max-height: 13.5cm; break-inside: avoid; }
  .scroll { overflow: visible; } tr, .figures div { break-inside: avoid; }
  details::details-content { content-visibility: visible; display: block; }
  table { font-size: 7.5pt; } th, td { padding: .2rem .3rem; }
  td:not(:last-child) { white-space: normal; } td:last-child:not(.n):not([colspan]) { min-width: 6rem; }
  tr.more div { max-width: none; } tr:has(+ .more) { break-after: avoid; }
  * { print-color-adjust: exact; -webkit-print-color-adjust: exact; }
}
)css";

}  // namespace planegraph
