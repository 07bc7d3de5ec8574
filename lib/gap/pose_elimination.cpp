#include "gap/pose_elimination.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace ballbar {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kNothingLeft = 1e-9;  // of a column's energy: rounding

/// Half as much again, so that a column more is not a copy each.
Index grown(Index size, Index needed) { return needed <= size ? size : std::max(needed, size + size / 2); }

void make_room(MatrixXd& matrix, Index rows, Index columns) {
  if (matrix.rows() < rows || matrix.cols() < columns)
    matrix.conservativeResize(grown(matrix.rows(), rows), grown(matrix.cols(), columns));
}

}  // namespace

PoseElimination::PoseElimination(const PoseModel& model, const std::vector<PoseRow>& rows, const PoseFit& fit,
                                 double least_sd)
    : model_(model), rows_(rows), start_(fit.state), least_sd_(least_sd) {
  data_ = model.residual(rows, start_, &geometry_);
  columns_ = pose_columns(model, rows, start_, geometry_);
  used_ = columns_.cols();
  weight_ = VectorXd::Constant(used_, 1.0 / (kPosePrior * kPosePrior));
  Index at = start_.nuisance(model.lengths());
  weight_.head(at) = prior_weights(start_, model.lengths()).head(at);
  std::size_t value = 0;
  for (const PoseTerm& term : start_.terms) {
    candidates_.push_back({term, at, true});
    for (int k = 0; k < term.width; ++k, ++at) {
      data_ += columns_.col(at) * start_.values[value++];
      columns_.col(at) *= term.typical;
    }
  }
  gram_ = MatrixXd::Zero(used_, used_);
  gram_.selfadjointView<Eigen::Lower>().rankUpdate(columns_.transpose());
  gram_.triangularView<Eigen::StrictlyUpper>() = gram_.transpose();
  right_ = columns_.transpose() * data_;
  sd_ = std::max(least_sd_, fit.sd);
  solve();
}

int PoseElimination::add(const PoseTerm& term) {
  make_room(columns_, columns_.rows(), used_ + term.width);
  make_room(gram_, used_ + term.width, used_ + term.width);
  columns_.middleCols(used_, term.width) = term.typical * model_.term_columns(rows_, term, geometry_);
  const auto added = columns_.middleCols(used_, term.width);
  const MatrixXd cross = columns_.leftCols(used_ + term.width).transpose() * added;
  gram_.block(0, used_, used_ + term.width, term.width) = cross;
  gram_.block(used_, 0, term.width, used_ + term.width) = cross.transpose();
  right_.conservativeResize(used_ + term.width);
  right_.tail(term.width) = added.transpose() * data_;
  weight_.conservativeResize(used_ + term.width);
  weight_.tail(term.width).setConstant(1.0 / (kPosePrior * kPosePrior));
  candidates_.push_back({term, used_, false});
  used_ += term.width;
  return static_cast<int>(candidates_.size()) - 1;
}

void PoseElimination::drop_candidates(int first) {
  std::vector<Index> keep;
  std::vector<Candidate> kept;
  for (Index k = 0; k < start_.nuisance(model_.lengths()); ++k) keep.push_back(k);
  for (int c = 0; c < candidates(); ++c) {
    Candidate candidate = candidates_[static_cast<std::size_t>(c)];
    if (c >= first && !candidate.taken) continue;
    const Index begin = candidate.begin;
    candidate.begin = static_cast<Index>(keep.size());
    for (int k = 0; k < candidate.term.width; ++k) keep.push_back(begin + k);
    kept.push_back(candidate);
  }
  candidates_ = std::move(kept);
  columns_ = columns_(Eigen::all, keep).eval();
  gram_ = gram_(keep, keep).eval();
  right_ = right_(keep).eval();
  weight_ = weight_(keep).eval();
  VectorXd solution = VectorXd::Zero(used_);  // what came since the last solution is not in it yet
  solution.head(solution_.size()) = solution_;
  solution_ = solution(keep);
  used_ = static_cast<Index>(keep.size());
}

void PoseElimination::take(int candidate) { candidates_[static_cast<std::size_t>(candidate)].taken = true; }
void PoseElimination::release(int candidate) {
  candidates_[static_cast<std::size_t>(candidate)].taken = false;
}

std::vector<Index> PoseElimination::columns_in() const {
  std::vector<Index> in;
  for (Index k = 0; k < start_.nuisance(model_.lengths()); ++k) in.push_back(k);
  for (const Candidate& candidate : candidates_)
    for (int k = 0; candidate.taken && k < candidate.term.width; ++k) in.push_back(candidate.begin + k);
  return in;
}

void PoseElimination::solve() {
  const std::vector<Index> in = columns_in();
  const MatrixXd gram = gram_(in, in), columns = columns_(Eigen::all, in);
  const VectorXd weight = weight_(in), right = right_(in);
  const auto readings = static_cast<double>(data_.size());
  const double dof = std::max(readings / 4.0, readings - static_cast<double>(in.size()));
  for (int i = 0; i < 2; ++i) {  // sd and prior hardly know of each other: twice is enough
    const double precision = 1.0 / std::max(1e-18, sd_ * sd_);
    MatrixXd normal = precision * gram;
    normal.diagonal() += weight;
    const VectorXd solution = normal.llt().solve(precision * right);
    solution_ = VectorXd::Zero(used_);
    solution_(in) = solution;
    residual_ = data_ - columns * solution;
    sd_ = crowding(rows_, residual_) * std::max(least_sd_, std::sqrt(residual_.squaredNorm() / dof));
  }
}

EvidenceProblem PoseElimination::problem(const std::vector<int>& chosen) const {
  const std::vector<Index> in = columns_in();
  std::vector<Index> out;
  EvidenceProblem problem;
  problem.begin.push_back(0);
  for (const int each : chosen) {
    const Candidate& candidate = candidates_[static_cast<std::size_t>(each)];
    for (int k = 0; k < candidate.term.width; ++k) out.push_back(candidate.begin + k);
    problem.begin.push_back(static_cast<Index>(out.size()));
  }
  const double precision = 1.0 / std::max(1e-18, sd_ * sd_);
  MatrixXd normal = precision * gram_(in, in);
  normal.diagonal() += weight_(in);
  const Eigen::LLT<MatrixXd> factor(normal);
  const MatrixXd cross = factor.matrixL().solve(MatrixXd(precision * gram_(in, out)));
  problem.gram = precision * gram_(out, out) - cross.transpose() * cross;
  problem.gram = (0.5 * (problem.gram + problem.gram.transpose())).eval();
  problem.raw_energy = precision * gram_(out, out).diagonal();
  problem.projection.resize(static_cast<Index>(out.size()));
  for (std::size_t k = 0; k < out.size(); ++k)
    problem.projection[static_cast<Index>(k)] = precision * columns_.col(out[k]).dot(residual_);
  problem.chi2 = precision * residual_.squaredNorm();
  for (Index k = 0; k < problem.gram.rows(); ++k)
    if (problem.gram(k, k) <= kNothingLeft * problem.raw_energy[k]) {
      problem.gram.row(k).setZero();
      problem.gram.col(k).setZero();
      problem.projection[k] = 0.0;
    }
  return problem;
}

PoseState PoseElimination::state() const {
  const int nuisance = start_.nuisance(model_.lengths());
  VectorXd step = VectorXd::Zero(nuisance + static_cast<Index>(start_.values.size()));
  step.head(nuisance) = solution_.head(nuisance);
  PoseState state = model_.moved(start_, step);
  state.terms.clear();
  state.values.clear();
  for (const Candidate& candidate : candidates_) {
    if (!candidate.taken) continue;
    state.terms.push_back(candidate.term);
    for (int k = 0; k < candidate.term.width; ++k)
      state.values.push_back(solution_[candidate.begin + k] * candidate.term.typical);
  }
  return state;
}

}  // namespace ballbar
