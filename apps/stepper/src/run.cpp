// SPDX-License-Identifier: MIT
#include "crease/stepper/run.hpp"

#include <algorithm>
#include <chrono>
#include <exception>
#include <span>
#include <sstream>
#include <utility>
#include <vector>

#include "checkpoint.hpp"
#include "crease/base/require.hpp"
#include "crease/collision/detect.hpp"
#include "digits.hpp"
#include "frames.hpp"
#include "output_file.hpp"
#include "output_obstacles.hpp"
#include "output_queue.hpp"
#include "output_steps.hpp"
#include "output_summary.hpp"
#include "resolution.hpp"
#include "run_advance.hpp"
#include "run_directory.hpp"
#include "run_schedule.hpp"

namespace crease {
namespace {

/// Often enough that little is lost when a run is killed, seldom enough that neither the file nor the steppers' cold
/// start is felt.
constexpr int steps_per_checkpoint = 20;

/// Lattice on which penetration inside a face is looked for; see max_penetration.
constexpr int penetration_level = 4;

/// Share of a step by which the wanted end may miss a step's end: scenes and --until are decimals.
constexpr double until_slack = 1e-6;

/// Share of the largest kinetic energy by which the energy may rise above that of the start where nothing drives the
/// cloth. What dissipates nothing leaves room for rounding alone; in the shipped scenes it does not rise at all.
constexpr double energy_slack = 0.01;

using Clock = std::chrono::steady_clock;
double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

/// What `parse` makes of a file; its complaints get the file's name.
template <class Parse>
auto parse_file(const std::filesystem::path& path, Parse parse) {
  const std::string bytes = read_whole(path);
  try {
    return parse(bytes);
  } catch (const std::exception& error) {
    throw FileError(path, error.what());
  }
}

std::string failed_step(const Schedule& schedule, int step, const std::string& why) {
  return "step " + std::to_string(step) + " (time " + digits(schedule.end_of(step - 1), 9) + " s to " +
         digits(schedule.end_of(step), 9) + " s), " + why;
}

bool nothing_drives(const Scene& scene) {
  const auto is_at_rest = [](const auto& mover) { return mover.motion.empty(); };
  return std::all_of(scene.obstacles.begin(), scene.obstacles.end(), is_at_rest) &&
         std::all_of(scene.cloths.begin(), scene.cloths.end(), [&](const ClothSpec& spec) {
           return std::all_of(spec.pins.begin(), spec.pins.end(), is_at_rest);
         });
}

/// Tries a scene's first step, for a run that is about to take an earlier one's place; writes nothing.
/// @return what failed, or nothing
std::optional<std::string> rehearse(const LoadedScene& loaded, const RunOptions& options) {
  const Schedule schedule(loaded.scene);
  if (schedule.n_steps == 0) return std::nullopt;
  Sheets sheets(loaded.scene, options.stages, options.threads);
  sheets.restart(loaded.cloths);
  StepRow row;
  const std::optional<std::string> failure = sheets.advance(0, schedule.size_of(1), row);
  if (!failure) return std::nullopt;
  return failed_step(schedule, 1, *failure) + "; what was in " + options.directory.string() + " is left as it was";
}

class Run {
 public:
  Run(const LoadedScene& loaded, const RunOptions& options);
  RunResult go(const std::function<bool(const RunProgress&)>& progress);

 private:
  Checkpoint sound_checkpoint(std::string_view bytes) const;
  void begin();
  std::vector<StepRow> kept_rows() const;
  RunResult take_steps(const std::function<bool(const RunProgress&)>& progress);
  std::optional<std::string> step();
  void measure_step(StepRow& row) const;
  void write_frame(int frame);
  void write_frame_list();
  void write_later(const std::filesystem::path& file, std::string bytes);
  void take_checkpoint();
  RunResult finish(RunStatus status, std::string message);
  void write_summary(bool finished, const std::string& why) const;
  double time() const { return schedule_.end_of(step_); }
  int n_frames() const { return schedule_.frames_until(step_); }
  RunProgress reached() const;
  std::vector<std::string> warnings() const;
  bool reached_end() const { return step_ >= schedule_.n_steps; }
  double wanted_end() const { return std::min(scene_.duration, options_.until.value_or(scene_.duration)); }
  bool reached_until() const { return options_.until && time() >= *options_.until - until_slack * schedule_.time_step; }

  const LoadedScene& loaded_;
  const Scene& scene_;
  const RunOptions& options_;
  const RunDirectory directory_;
  const Schedule schedule_;
  const Energies start_;
  const std::vector<std::string> unresolved_;
  std::optional<std::string> missing_frames_;  ///< of the run that is resumed
  Sheets sheets_;
  Tally tally_;
  std::optional<LineFile> steps_file_;
  int step_ = 0;
  double checkpoint_seconds_ = 0;  // wall time of a checkpoint taken since the last row
  OutputQueue output_;             // of all that is written between the steps
};

Run::Run(const LoadedScene& loaded, const RunOptions& options)
    : loaded_(loaded),
      scene_(loaded.scene),
      options_(options),
      directory_{options.directory},
      schedule_(loaded.scene),
      start_(measure(loaded.scene, loaded.cloths)),
      unresolved_(unresolved_features(loaded)),
      sheets_(loaded.scene, options.stages, options.threads) {
  const bool anew = options.force && !options.resume;
  if (anew || !std::filesystem::exists(directory_.checkpoint()))
    write_whole(directory_.checkpoint(), encode_checkpoint(loaded_.resolved_json, 0, loaded_.cloths));
  sync_folder(directory_.root);
  begin();
}

/// One that this scene's run may have written: a hash finds what the disk spoiled, this what was wrong when it was
/// made.
Checkpoint Run::sound_checkpoint(std::string_view bytes) const {
  Checkpoint checkpoint = decode_checkpoint(bytes);
  const auto expect = [](bool holds, const std::string& trouble) {
    if (!holds) throw std::runtime_error("checkpoint is unsound: " + trouble);
  };
  expect(checkpoint.step >= 0 && checkpoint.step <= schedule_.n_steps, "the scene has no such step");
  expect(checkpoint.cloths.size() == scene_.cloths.size(), "the scene has another number of cloths");
  std::vector<PosedObstacle> posed;
  for (const Obstacle& obstacle : scene_.obstacles)
    posed.push_back({&obstacle.shape, pose_at(obstacle, schedule_.end_of(checkpoint.step))});
  const double longest = (linger_steps + 1) * schedule_.time_step;  // the last part of a step may end just after
  for (const Cloth& cloth : checkpoint.cloths) {
    const std::optional<std::string> trouble = validate(cloth, posed, longest);
    expect(!trouble, trouble.value_or(""));
  }
  return checkpoint;
}

/// Goes on from the checkpoint; a new run has one of step 0. Whatever stands in the folder of a run before it, or of
/// what a killed run wrote after it, is dropped.
void Run::begin() {
  Checkpoint checkpoint =
      parse_file(directory_.checkpoint(), [this](const std::string& bytes) { return sound_checkpoint(bytes); });
  step_ = checkpoint.step;
  sheets_.restart(std::move(checkpoint.cloths));
  std::string table = steps_header();
  for (const StepRow& row : kept_rows()) {
    table += to_csv(row);
    tally_.add(row);
  }
  std::filesystem::create_directories(directory_.root / "frames");
  if (step_ == 0)
    remove_earlier_run(directory_);
  else
    remove_frames(directory_, n_frames());
  if (step_ > 0) missing_frames_ = missing_frames(directory_, scene_.formats, n_frames());
  write_whole(directory_.root / "scene.json", loaded_.resolved_json);
  write_whole(directory_.root / "obstacles.json", obstacles_json(scene_.obstacles, schedule_.frame_times));
  write_whole(directory_.steps(), table);
  steps_file_.emplace(directory_.steps());
  if (step_ == 0) write_frame(0);
  write_frame_list();
  write_summary(false, "running, or killed while it ran");
}

std::vector<StepRow> Run::kept_rows() const {
  if (step_ == 0) return {};
  const auto n_steps = static_cast<std::size_t>(step_);
  std::vector<StepRow> rows =
      parse_file(directory_.steps(), [n_steps](const std::string& text) { return parse_steps(text, n_steps); });
  if (rows.size() < n_steps) throw FileError(directory_.steps(), "holds fewer rows than the checkpoint has steps");
  return rows;
}

RunResult Run::go(const std::function<bool(const RunProgress&)>& progress) {
  try {
    return take_steps(progress);
  } catch (const FileError& error) {
    try {
      write_summary(false, error.what());
    } catch (const FileError&) {  // the same trouble; the result tells it
    }
    throw;
  }
}

RunResult Run::take_steps(const std::function<bool(const RunProgress&)>& progress) {
  while (!reached_end() && !reached_until()) {
    if (std::optional<std::string> failure = step()) return finish(RunStatus::SimulationFailed, std::move(*failure));
    const bool go_on = !progress || progress(reached());
    if (!go_on && !reached_end() && !reached_until())
      return finish(RunStatus::Interrupted, "interrupted after step " + std::to_string(step_) + " (time " +
                                                digits(time(), 9) + " s); --resume continues");
  }
  return finish(RunStatus::Done, reached_end() ? "reached the end of the scene"
                                               : "stopped at time " + digits(time(), 9) +
                                                     " s, as --until asked for; --resume continues");
}

RunProgress Run::reached() const {
  const StepRow &row = tally_.last(), &sums = tally_.sums();
  return {time(),
          wanted_end(),
          sums.t_total,
          step_,
          static_cast<int>(row.faces),
          static_cast<int>(row.eol_vertices),
          static_cast<int>(row.contacts),
          static_cast<int>(sums.retries),
          tally_.deepest().max_penetration};
}

/// One step and its row. @return what failed, or nothing
std::optional<std::string> Run::step() {
  const auto start = Clock::now();
  StepRow row;
  row.step = step_ + 1;
  row.time = schedule_.end_of(step_ + 1);
  row.time_step = schedule_.size_of(step_ + 1);
  if (std::optional<std::string> failure = sheets_.advance(time(), row.time_step, row))
    return failed_step(schedule_, step_ + 1, *failure);
  ++step_;

  const auto output_start = Clock::now();
  measure_step(row);
  if (n_frames() > schedule_.frames_until(step_ - 1)) {
    write_frame(n_frames() - 1);
    write_frame_list();
  }
  row.t_output = std::exchange(checkpoint_seconds_, 0.0);
  row.t_total = row.t_output + seconds_since(start);
  row.t_output += seconds_since(output_start);
  steps_file_->append(to_csv(row));
  tally_.add(row);
  // Last, so that frames and rows up to a checkpoint's step are always on disk.
  if (step_ % steps_per_checkpoint == 0 || reached_end()) {
    take_checkpoint();
  }
  return std::nullopt;
}

/// Fills the columns that describe the state at the end of the step.
void Run::measure_step(StepRow& row) const {
  for (const Cloth& cloth : sheets_.cloths()) {
    row.faces += cloth.mesh.n_faces();
    row.vertices += cloth.mesh.n_vertices();
    row.eol_vertices += cloth.n_eol();
  }
  const Energies now = measure(scene_, sheets_.cloths());
  row.kinetic_energy = now.kinetic;
  row.membrane_energy = now.membrane;
  row.bending_energy = now.bending;
  row.gravitational_energy = now.gravitational;
  row.momentum_x = now.momentum.x(), row.momentum_y = now.momentum.y(), row.momentum_z = now.momentum.z();
  row.angular_momentum_x = now.angular_momentum.x(), row.angular_momentum_y = now.angular_momentum.y();
  row.angular_momentum_z = now.angular_momentum.z();
  if (scene_.obstacles.empty()) return;
  std::vector<PosedObstacle> posed;
  for (const Obstacle& obstacle : scene_.obstacles) posed.push_back({&obstacle.shape, pose_at(obstacle, time())});
  for (const Cloth& cloth : sheets_.cloths())
    row.max_penetration = std::max(row.max_penetration, max_penetration(cloth, posed, penetration_level));
}

void Run::write_later(const std::filesystem::path& file, std::string bytes) {
  output_.push([path = directory_.root / file, text = std::move(bytes)] { write_whole(path, text); });
}

void Run::write_frame(int frame) {
  std::vector<NamedCloth> cloths;
  for (std::size_t c = 0; c < scene_.cloths.size(); ++c)
    cloths.push_back({scene_.cloths[c].name, &sheets_.cloths()[c]});
  for (const FrameFormat format : scene_.formats) {
    if (format == FrameFormat::Vtp) {
      write_later(frame_path(frame, "vtp"), vtp_text(cloths, time()));
    } else {
      std::ostringstream text;
      write_obj(text, cloths, time());
      write_later(frame_path(frame, "obj"), text.str());
    }
  }
}

void Run::write_frame_list() {
  if (std::find(scene_.formats.begin(), scene_.formats.end(), FrameFormat::Vtp) == scene_.formats.end()) return;
  const std::span<const double> times(schedule_.frame_times);
  write_later("cloth.pvd", pvd_text(times.first(static_cast<std::size_t>(n_frames()))));
}

/// Has the state written, once all that it relies on is on the disk, and goes on from what is written, as a resumed run
/// will: the mesh's inner order and the steppers' memory of earlier steps do influence the last bits.
void Run::take_checkpoint() {
  const auto start = Clock::now();
  std::string bytes = encode_checkpoint(loaded_.resolved_json, step_, sheets_.cloths());
  sheets_.restart(decode_checkpoint(bytes).cloths);
  output_.push([this, state = std::move(bytes)] {
    steps_file_->sync();
    sync_folder(directory_.root / "frames");
    sync_folder(directory_.root);
    write_whole(directory_.checkpoint(), state);
  });
  checkpoint_seconds_ = seconds_since(start);
}

std::vector<std::string> Run::warnings() const {
  std::vector<std::string> all = unresolved_;
  if (missing_frames_) all.push_back(*missing_frames_);
  if (const double n = tally_.sums().held; n > 0)
    all.push_back("EOL vertices were kept from running over the triangles ahead " + digits(n, 9) +
                  " times, and the cloth from sliding there meanwhile: see 'held' in steps.csv");
  if (const double n = tally_.sums().caught; n > 0)
    all.push_back("the cloth was caught between features in " + digits(n, 9) +
                  " parts of steps, and not pushed out of them meanwhile: see 'caught' in steps.csv");
  if (const StepRow& row = tally_.deepest(); row.max_penetration > scene_.threshold)
    all.push_back("the cloth was inside an obstacle by " + digits(row.max_penetration, 3) + " m at " +
                  digits(row.time, 9) + " s, more than the contact threshold: see 'max_penetration' in steps.csv");
  const double gained = tally_.most_energy() - start_.total();
  const double swing = std::max(start_.kinetic, tally_.most_kinetic_energy());
  if (nothing_drives(scene_) && gained > energy_slack * swing)
    all.push_back("the energy rose by " + digits(gained, 9) +
                  " J above that of the start, though nothing drives the cloth: " +
                  "the time step is too long, or the mesh too coarse for what happens");
  return all;
}

RunResult Run::finish(RunStatus status, std::string message) {
  output_.finish();
  const bool done = status == RunStatus::Done;
  write_summary(done && reached_end(), message);
  return {status, done ? std::string() : std::move(message), reached(), warnings()};
}

void Run::write_summary(bool finished, const std::string& why) const {
  const Summary summary{finished, why, options_.command_line, n_frames(), sheets_.left_out(), warnings(), start_};
  write_whole(directory_.root / "summary.json", summary_json(scene_, summary, tally_));
}

}  // namespace

RunResult run_scene(const LoadedScene& loaded, const RunOptions& options,
                    const std::function<bool(const RunProgress&)>& progress) {
  require(loaded.cloths.size() == loaded.scene.cloths.size(), "run_scene: expected one cloth for each of the scene's");
  try {
    const RunDirectory directory{options.directory};
    if (std::optional<std::string> why = refusal(directory, options, loaded))
      return {RunStatus::Refused, std::move(*why)};
    if (options.resume && std::filesystem::exists(directory.checkpoint()) &&
        !parse_file(directory.checkpoint(),
                    [&](const std::string& bytes) { return belongs_to(bytes, loaded.resolved_json); }))
      return {RunStatus::Refused,
              directory.root.string() + ": holds a run of another scene; --resume needs the same scene and --set"};
    std::filesystem::create_directories(directory.root);
    const DirectoryLock lock(directory);
    if (lock.taken_by_another()) return {RunStatus::Refused, directory.root.string() + ": another run is writing here"};
    if (options.force && !options.resume && !std::filesystem::is_empty(directory.root))
      if (std::optional<std::string> failure = rehearse(loaded, options))
        return {RunStatus::SimulationFailed, std::move(*failure)};
    return Run(loaded, options).go(progress);
  } catch (const FileError& error) {
    return {RunStatus::FileTrouble, error.what()};
  } catch (const std::filesystem::filesystem_error& error) {
    return {RunStatus::FileTrouble, error.path1().string() + ": " + error.code().message()};
  }
}

}  // namespace crease
