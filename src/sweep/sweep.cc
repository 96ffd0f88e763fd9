#include "planegraph/sweep/sweep.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstring>
#include <deque>
#include <filesystem>
#include <mutex>

#include "planegraph/base/atomic_file.h"
#include "planegraph/base/error.h"
#include "planegraph/base/parallel.h"
#include "sweep/fingerprint.h"
#include "sweep/metrics.h"
#include "sweep/stage.h"

namespace planegraph {
namespace {

namespace fs = std::filesystem;

constexpr int kWrongUsage = 1;  // exit code of the tool

// One sweep at a time in a folder; a killed one lets go of it.
class FolderLock {
 public:
  explicit FolderLock(const std::string& folder)
      : file_(::open((folder + "/.lock").c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644)) {
    if (file_ < 0) {
      throw InputError::InFile(folder, std::string("cannot be written: ") + std::strerror(errno));
    }
    if (::flock(file_, LOCK_EX | LOCK_NB) == 0) return;
    ::close(file_);
    throw UsageError("another sweep works in " + folder);
  }
  ~FolderLock() { ::close(file_); }
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

 private:
  int file_;
};

// The site of one data set and seed. Its runs share it.
struct SiteState {
  std::size_t data_set = 0;
  std::uint64_t seed = 0;
  std::string folder;  // of a simulated one
  std::string file, truth;
  std::string key;                // of what it holds
  std::mutex mutex;               // held while it is simulated
  std::atomic<int> open_runs{0};  // that may still need it
};

class Sweep {
 public:
  Sweep(const Experiment& experiment, const SweepOptions& options)
      : experiment_(experiment), options_(options) {}

  std::vector<SweepRun> Run();

 private:
  void Prepare();
  void AddSite(std::size_t data_set, std::uint64_t seed, const std::string& site_key);
  Stage SimulateStage(const SiteState& site) const;
  Stage MapStage(const SweepRun& run, const SiteState& site) const;
  Stage SharpnessStage(const SweepRun& run, const Stage& map) const;
  StageRecord EnsureSite(SiteState* site) const;
  StageRecord Map(const Stage& stage, SweepRun* run, SiteState* site) const;
  void MeasureSharpness(const Stage& stage) const;
  void Refuse(const StageRecord& record, std::size_t line, const std::string& what) const;
  void CarryOut(SweepRun* run, SiteState* site) const;
  void Tidy(const SweepRun& run, SiteState* site) const;
  void Report(const SweepRun& run);

  const Experiment& experiment_;
  const SweepOptions& options_;
  std::string program_key_;
  std::deque<SiteState> sites_;  // of consecutive runs, as many as there are variants
  std::vector<SweepRun> runs_;
  std::atomic<bool> stopped_{false};
  std::mutex report_mutex_;
  std::size_t done_ = 0;
};

void AddFlags(const FlagValues& flags, std::vector<std::string>* command) {
  for (const auto& [name, value] : flags) command->push_back("--" + name + "=" + value);
}

void AddFlags(const FlagValues& flags, Fingerprint* print) {
  for (const auto& [name, value] : flags) print->Add(name).Add(value);
}

void Sweep::AddSite(std::size_t data_set, std::uint64_t seed, const std::string& site_key) {
  const SweepDataSet& set = experiment_.data_sets[data_set];
  SiteState& site = sites_.emplace_back();
  site.data_set = data_set;
  site.seed = seed;
  site.open_runs = static_cast<int>(experiment_.variants.size());
  site.file = set.site;
  site.truth = set.truth;
  site.key = site_key;
  if (!set.is_simulated()) return;
  site.folder = options_.folder + "/sites/" + set.name + "/" + std::to_string(seed);
  site.file = site.folder + "/" + set.map_file;
  site.truth = site.folder + "/truth/similarity.json";
  site.key = SimulateStage(site).key;
}

void Sweep::Prepare() {
  program_key_ = Fingerprint().Add(ReadTextFile(options_.program)).Hex();
  for (std::size_t d = 0; d < experiment_.data_sets.size(); ++d) {
    const SweepDataSet& set = experiment_.data_sets[d];
    const std::string site_key = set.is_simulated() ? "" : SiteFingerprint(set.site);
    for (std::uint64_t seed : set.seeds) {
      AddSite(d, seed, site_key);
      for (std::size_t v = 0; v < experiment_.variants.size(); ++v) {
        SweepRun& run = runs_.emplace_back();
        run.data_set = d;
        run.variant = v;
        run.seed = seed;
        run.folder = options_.folder + "/runs/" + set.name + "/" + experiment_.variants[v].name +
                     "/" + std::to_string(seed);
      }
    }
  }
}

Stage Sweep::SimulateStage(const SiteState& site) const {
  const SweepDataSet& set = experiment_.data_sets[site.data_set];
  Stage stage{"simulate", site.folder, {options_.program, "simulate"}, ""};
  AddFlags(set.simulate, &stage.command);
  stage.command.push_back("--seed=" + std::to_string(site.seed));
  stage.command.push_back("--threads=" + std::to_string(experiment_.threads));
  stage.command.push_back("--output_dir=" + site.folder);
  Fingerprint print;
  print.Add(program_key_).Add("simulate").Add(std::to_string(site.seed));
  print.Add(std::to_string(experiment_.threads));
  AddFlags(set.simulate, &print);
  stage.key = print.Hex();
  return stage;
}

Stage Sweep::MapStage(const SweepRun& run, const SiteState& site) const {
  const SweepDataSet& set = experiment_.data_sets[run.data_set];
  const FlagValues& flags = experiment_.variants[run.variant].flags;
  Stage stage{"map", run.folder, {options_.program, "map", site.file}, ""};
  AddFlags(flags, &stage.command);
  stage.command.push_back("--seed=" + std::to_string(run.seed));
  stage.command.push_back("--threads=" + std::to_string(experiment_.threads));
  stage.command.push_back("--output_dir=" + run.folder);
  Fingerprint print;
  print.Add(program_key_).Add("map").Add(std::to_string(run.seed)).Add(site.key);
  print.Add(std::to_string(experiment_.threads)).Add(set.is_simulated() ? set.map_file : "");
  AddFlags(flags, &print);
  stage.key = print.Hex();
  return stage;
}

Stage Sweep::SharpnessStage(const SweepRun& run, const Stage& map) const {
  return {"evaluate",
          run.folder,
          {options_.program, "evaluate", "--map=" + run.folder + "/map.ply", "--mpv=false",
           "--quiet", "--threads=" + std::to_string(experiment_.threads),
           "--output=" + run.folder + "/evaluate.json"},
          Fingerprint().Add(map.key).Add("evaluate").Hex()};
}

// What the tool calls wrong usage is a mistake of the experiment, not a result.
void Sweep::Refuse(const StageRecord& record, std::size_t line, const std::string& what) const {
  if (record.exit_code != kWrongUsage) return;
  throw InputError::AtLine(experiment_.path, line, what + ": " + record.reason);
}

StageRecord Sweep::EnsureSite(SiteState* site) const {
  const std::lock_guard<std::mutex> lock(site->mutex);
  const Stage stage = SimulateStage(*site);
  if (const auto record = FindRecord(stage)) return *record;
  fs::remove_all(site->folder);
  CreateFolder(site->folder);
  const StageRecord record = RunStage(stage);
  const SweepDataSet& set = experiment_.data_sets[site->data_set];
  Refuse(record, set.line, "the simulation of " + set.name + " fails");
  return record;
}

StageRecord Sweep::Map(const Stage& stage, SweepRun* run, SiteState* site) const {
  fs::remove_all(run->folder);
  CreateFolder(run->folder);
  if (!site->folder.empty()) {
    StageRecord simulated = EnsureSite(site);
    simulated.reason = "simulate: " + simulated.reason;
    if (simulated.exit_code != 0) return simulated;
  }
  const StageRecord record = RunStage(stage);
  const SweepVariant& variant = experiment_.variants[run->variant];
  Refuse(record, variant.line, "the variant " + variant.name + " fails");
  return record;
}

void Sweep::MeasureSharpness(const Stage& stage) const {
  const std::string result = stage.folder + "/evaluate.json";
  if (FindRecord(stage)) return;
  fs::remove(result);
  RunStage(stage);
}

void Sweep::CarryOut(SweepRun* run, SiteState* site) const {
  const Stage stage = MapStage(*run, *site);
  const Stage sharpness = SharpnessStage(*run, stage);
  const bool wants_sharpness = NeedsSharpness(experiment_.metrics);
  auto record = FindRecord(stage);
  const std::string map = run->folder + "/map.ply";
  // Of a run that was tidied up the map is gone, and with it what has not been measured of it.
  const bool lacks_map = record && record->exit_code == 0 && wants_sharpness &&
                         !FindRecord(sharpness) && !fs::exists(map);
  if (lacks_map) record.reset();
  run->reused = record.has_value();
  if (!record) record = Map(stage, run, site);
  if (wants_sharpness && fs::exists(map)) MeasureSharpness(sharpness);
  run->exit_code = record->exit_code;
  run->reason = record->reason;
  run->values = Measure(experiment_.metrics, {run->folder, site->truth}, *record);
  Tidy(*run, site);
}

bool IsResult(const fs::path& path) {
  return path.extension() == ".json" || path.extension() == ".log" || path.extension() == ".tum";
}

void Sweep::Tidy(const SweepRun& run, SiteState* site) const {
  const bool is_last = --site->open_runs == 0;
  if (experiment_.keeps_everything) return;
  std::vector<fs::path> bulk;
  for (const auto& entry : fs::directory_iterator(run.folder)) {
    if (entry.is_directory() || !IsResult(entry.path())) bulk.push_back(entry.path());
  }
  // Without its record a site is made again where a further run needs it; its truth stays.
  if (is_last && fs::exists(site->folder)) {
    for (const auto& entry : fs::directory_iterator(site->folder)) {
      const bool is_truth = entry.path().filename() == "truth";
      if (!is_truth && entry.path().extension() != ".log") bulk.push_back(entry.path());
    }
    bulk.emplace_back(site->folder + "/truth/labels");
  }
  for (const fs::path& path : bulk) fs::remove_all(path);
}

void Sweep::Report(const SweepRun& run) {
  const std::lock_guard<std::mutex> lock(report_mutex_);
  ++done_;
  if (!options_.progress) return;
  const std::string name = experiment_.data_sets[run.data_set].name + "/" +
                           experiment_.variants[run.variant].name + "/" + std::to_string(run.seed);
  options_.progress(name, static_cast<double>(done_) / static_cast<double>(runs_.size()));
}

std::vector<SweepRun> Sweep::Run() {
  CreateFolder(options_.folder);
  const FolderLock lock(options_.folder);
  Prepare();
  const std::size_t variants = experiment_.variants.size();
  ParallelFor(runs_.size(), options_.jobs, [&](std::size_t i) {
    if (stopped_) return;
    try {
      CarryOut(&runs_[i], &sites_[i / variants]);
      Report(runs_[i]);
    } catch (...) {
      stopped_ = true;
      throw;
    }
  });
  return std::move(runs_);
}

}  // namespace

std::vector<SweepRun> RunSweep(const Experiment& experiment, const SweepOptions& options) {
  return Sweep(experiment, options).Run();
}

}  // namespace planegraph
