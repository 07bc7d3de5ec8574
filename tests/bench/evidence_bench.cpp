// Time of the noise spectrum, whitening and evidence search of 34 laps of 400 samples. Usage: evidence_bench

#include <chrono>
#include <cstdio>
#include <random>
#include <vector>

#include "numerics/evidence_search.hpp"
#include "numerics/noise_spectrum.hpp"
#include "numerics/whitening.hpp"

namespace {

using Eigen::Index;
using Eigen::MatrixXd;

/// [ms] per call, the best of five: what the machine can do when nothing else runs.
template <typename Call>
double milliseconds(Call call) {
  double best = 1e300;
  for (int round = 0; round < 5; ++round) {
    const auto begin = std::chrono::steady_clock::now();
    call();
    const std::chrono::duration<double, std::milli> took = std::chrono::steady_clock::now() - begin;
    best = std::min(best, took.count());
  }
  return best;
}

MatrixXd normal_matrix(std::mt19937_64& random, Index rows, Index cols) {
  std::normal_distribution<double> normal;
  MatrixXd m(rows, cols);
  for (double& v : m.reshaped()) v = normal(random);
  return m;
}

void search_bench(std::mt19937_64& random, const std::vector<int>& widths) {
  Index p = 0;
  for (const int width : widths) p += width;
  const Index rows = Index{34} * 361, k = 60;
  const MatrixXd baseline = normal_matrix(random, rows, k), candidates = normal_matrix(random, rows, p);
  const Eigen::VectorXd y = normal_matrix(random, rows, 1) + candidates.col(0);
  ballbar::EvidenceProblem problem;
  const double gram = milliseconds([&] {
    problem = ballbar::eliminate_baseline(y, baseline, Eigen::VectorXd::Ones(k), candidates, widths);
  });
  int visited = 0;
  const double search = milliseconds([&] { visited = ballbar::search_evidence(problem).visited; });
  const double alike = milliseconds([&] { ballbar::resemblance(problem); });
  std::printf(
      "%zu groups, %d columns: baseline and Gram %.0f ms, search of %d sets %.1f ms, resemblance %.1f ms\n",
      widths.size(), static_cast<int>(p), gram, visited, search, alike);
}

}  // namespace

int main() {
  std::mt19937_64 random(1);
  for (const Index samples : {Index{400}, Index{397}, Index{3000}}) {
    const ballbar::CosineTransform transform(samples, 1.0, 180.0);
    const MatrixXd values = normal_matrix(random, samples, 170);
    std::printf("%d samples: 170 columns %.2f ms\n", static_cast<int>(samples),
                milliseconds([&] { transform(values); }));
  }
  std::vector<ballbar::RepeatScatter> scatter;
  const ballbar::CosineTransform transform(400, 1.0, 180.0);
  for (int i = 0; i < 34; ++i)
    scatter.push_back(
        ballbar::repeat_scatter(transform.frequency(), transform(normal_matrix(random, 400, 2))));
  std::printf("spectrum of 34 recordings %.2f ms\n",
              milliseconds([&] { ballbar::fit_noise_spectrum(scatter); }));
  std::vector<int> widths(60, 1);
  for (std::size_t i = 0; i < 30; ++i) widths[2 * i] = 2;
  search_bench(random, widths);
  widths.insert(widths.end(), 15, 34);
  search_bench(random, widths);
}
