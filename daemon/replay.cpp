#include "daemon/replay.hpp"

#include "bus/decode.hpp"
#include "bus/subscriber.hpp"

namespace ballbar {

ReplayOutcome replay(const LogFile& log, Service& service, const std::function<void(double)>& progress) {
  constexpr std::int64_t kProgressEvery = 5000;  // messages
  ReplayOutcome outcome;
  Assembler assembler(service.config().robots, {}, recogniser_of(service.models()));
  std::vector<Run> finished;
  std::int64_t messages = 0;
  std::int64_t first_us = 0;
  Subscriber subscriber(log.url,
                        [&](Channel channel, std::span<const std::uint8_t> bytes, std::int64_t arrival_us) {
                          if (messages == 0) first_us = arrival_us;
                          const Decoded decoded = decode(channel, bytes);
                          if (const Refusal* reason = std::get_if<Refusal>(&decoded))
                            assembler.refuse(*reason);
                          else
                            assembler.take(std::get<Sample>(decoded), arrival_us, finished);
                          assembler.tick(arrival_us, finished);
                          if (++messages % kProgressEvery == 0 && progress)
                            progress(static_cast<double>(arrival_us - first_us) * 1e-6);
                        });
  while (subscriber.handle()) {
    for (Run& run : finished) service.on_run(std::move(run));
    finished.clear();
  }
  assembler.close_all(RunEnd::kSilence, finished);
  for (Run& run : finished) service.on_run(std::move(run));
  service.retry();
  outcome.messages = assembler.counters();
  return outcome;
}

}  // namespace ballbar
