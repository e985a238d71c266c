// SPDX-License-Identifier: MIT
#include "progress.hpp"

#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <utility>

namespace crease::cli {
namespace {

constexpr double terminal_period = 0.1, plain_period = 5;  // seconds between two updates

template <typename... Values>
std::string format(const char* pattern, Values... values) {
  std::array<char, 256> text{};
  std::snprintf(text.data(), text.size(), pattern, values...);
  return text.data();
}

size_t terminal_columns() {
  winsize size{};
  return ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0 ? size.ws_col : 80;
}

std::string numbers(const RunProgress& p, double remaining) {
  return format("%.2f/%.4g s  ETA %s  %d faces  %d contacts  %d EOL", p.time, p.duration, clock_text(remaining).c_str(),
                p.faces, p.contacts, p.eol_vertices) +
         (p.retries > 0 ? format("  %d retries", p.retries) : "");
}

double share(const RunProgress& p) {
  return p.duration > 0 ? std::clamp(p.time / p.duration, 0.0, 1.0) : 1.0;
}

}  // namespace

std::string clock_text(double seconds) {
  if (!std::isfinite(seconds) || seconds > 359999) return "-:--";
  const int s = static_cast<int>(std::lround(std::max(seconds, 0.0)));
  if (s < 3600) return format("%d:%02d", s / 60, s % 60);
  return format("%d:%02d:%02d", s / 3600, s / 60 % 60, s % 60);
}

Progress::Progress(std::string name, bool quiet)
    : name_(std::move(name)),
      quiet_(quiet),
      terminal_(isatty(STDERR_FILENO) == 1),
      begin_(Clock::now()),
      shown_(begin_) {}

std::string Progress::bar(const RunProgress& p, double remaining) const {
  const std::string before = name_ + " [", after = format("] %3.0f %%  ", 100 * share(p)) + numbers(p, remaining);
  const size_t columns = terminal_columns() - 1, taken = before.size() + after.size();
  const size_t width = std::clamp<size_t>(columns > taken ? columns - taken : 0, 4, 40);
  const auto full = static_cast<size_t>(share(p) * static_cast<double>(width));
  std::string line = before + std::string(full, '#') + std::string(width - full, '.') + after;
  line.resize(std::min(line.size(), columns));
  return line;
}

void Progress::update(const RunProgress& p) {
  if (quiet_) return;
  const Clock::time_point now = Clock::now();
  if (!first_time_) {
    first_time_ = p.time;
    begin_ = now;
  }
  const double period = terminal_ ? terminal_period : plain_period;
  if (std::chrono::duration<double>(now - shown_).count() < period) return;
  shown_ = now;
  const double elapsed = std::chrono::duration<double>(now - begin_).count(), gained = p.time - *first_time_;
  const double remaining = gained > 0 ? elapsed / gained * (p.duration - p.time) : INFINITY;
  if (terminal_) {
    std::fprintf(stderr, "\r\033[K%s", bar(p, remaining).c_str());
    line_open_ = true;
  } else {
    std::fprintf(stderr, "%s: %.0f %%  %s\n", name_.c_str(), 100 * share(p), numbers(p, remaining).c_str());
  }
  std::fflush(stderr);
}

void Progress::finish() {
  if (line_open_) std::fprintf(stderr, "\r\033[K");
  line_open_ = false;
}

}  // namespace crease::cli
