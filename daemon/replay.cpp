#include "daemon/replay.hpp"

#include "bus/decode.hpp"

namespace ballbar {

AssemblerCounters read_runs(const LogFile& log, const std::vector<RobotSpec>& robots, const Models& models,
                            const std::function<void(Run)>& take,
                            const std::function<void(BaselineMark)>& calibrated,
                            const std::function<void(double)>& progress) {
  constexpr std::int64_t kProgressEvery = 5000;  // messages
  Assembler assembler(robots, {}, recogniser_of(models));
  std::vector<Run> finished;
  std::int64_t messages = 0;
  std::int64_t first_us = 0;
  const auto hand_on = [&] {
    for (BaselineMark& mark : assembler.calibrations())
      if (calibrated) calibrated(std::move(mark));
    for (Run& run : finished) take(std::move(run));
    finished.clear();
  };
  read_log(log, [&](Channel channel, std::span<const std::uint8_t> bytes, std::int64_t arrival_us) {
    if (messages == 0) first_us = arrival_us;
    const Decoded decoded = decode(channel, bytes);
    if (const Refusal* reason = std::get_if<Refusal>(&decoded))
      assembler.refuse(*reason);
    else
      assembler.take(std::get<Sample>(decoded), arrival_us, finished);
    assembler.tick(arrival_us, finished);
    hand_on();
    if (++messages % kProgressEvery == 0 && progress)
      progress(static_cast<double>(arrival_us - first_us) * 1e-6);
  });
  assembler.close_all(RunEnd::kSilence, finished);
  hand_on();
  return assembler.counters();
}

ReplayOutcome replay(const LogFile& log, Service& service, const std::function<void(double)>& progress) {
  ReplayOutcome outcome;
  outcome.messages = read_runs(
      log, service.config().robots, service.models(), [&](Run run) { service.on_run(std::move(run)); },
      [&](BaselineMark mark) { service.on_calibration(std::move(mark)); }, progress);
  service.retry();
  return outcome;
}

}  // namespace ballbar
