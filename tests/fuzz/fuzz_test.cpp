// Every input from outside: its corpus, and a fixed number of mutations of it.

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <random>
#include <vector>

#include "fuzz/targets.hpp"
#include "support/process.hpp"

namespace ballbar {
namespace {

using Input = std::vector<std::uint8_t>;

std::vector<Input> corpus(const std::string& target) {
  std::vector<std::string> paths;
  for (const auto& entry :
       std::filesystem::directory_iterator(BALLBAR_SOURCE_DIR "/tests/fuzz/corpus/" + target))
    paths.push_back(entry.path());
  std::sort(paths.begin(), paths.end());
  std::vector<Input> inputs;
  for (const std::string& path : paths) {
    const std::string bytes = test::read_file(path);
    inputs.emplace_back(bytes.begin(), bytes.end());
  }
  return inputs;
}

/// Bytes changed, cut out, doubled, or taken from another input.
Input mutated(Input input, const Input& other, std::mt19937_64& rng) {
  const auto some = [&](std::size_t size) { return static_cast<std::ptrdiff_t>(rng() % (size + 1)); };
  for (std::uint64_t n = 1 + rng() % 4; n > 0; --n) {
    const std::ptrdiff_t at = some(input.size());
    const std::ptrdiff_t end =
        std::min<std::ptrdiff_t>(at + some(16), static_cast<std::ptrdiff_t>(input.size()));
    switch (rng() % 4) {
      case 0:
        for (std::ptrdiff_t i = at; i < end; ++i)
          input[static_cast<std::size_t>(i)] = static_cast<std::uint8_t>(rng());
        break;
      case 1:
        input.erase(input.begin() + at, input.begin() + end);
        break;
      case 2: {
        const Input piece(input.begin() + at, input.begin() + end);
        input.insert(input.begin() + end, piece.begin(), piece.end());
        break;
      }
      default: {
        const std::ptrdiff_t from = some(other.size());
        const auto to = std::min<std::ptrdiff_t>(from + some(16), static_cast<std::ptrdiff_t>(other.size()));
        input.insert(input.begin() + at, other.begin() + from, other.begin() + to);
      }
    }
  }
  return input;
}

class Fuzz : public testing::TestWithParam<fuzz::Target> {};

TEST_P(Fuzz, TheCorpusAndItsMutationsAreTakenOrRefused) {
  const std::vector<Input> inputs = corpus(std::string(GetParam().name));
  ASSERT_FALSE(inputs.empty());
  for (const Input& input : inputs) EXPECT_NO_THROW(GetParam().run(input));
  for (unsigned seed = 0; seed < 300; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937_64 rng(seed);
    const Input input = mutated(inputs[rng() % inputs.size()], inputs[rng() % inputs.size()], rng);
    EXPECT_NO_THROW(GetParam().run(input));
  }
}

INSTANTIATE_TEST_SUITE_P(Inputs, Fuzz, testing::ValuesIn(fuzz::kTargets),
                         [](const auto& target) { return std::string(target.param.name); });

}  // namespace
}  // namespace ballbar
