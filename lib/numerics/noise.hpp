#pragma once
/// Noise from sample to sample.

#include <Eigen/Core>

namespace ballbar {

/// Standard deviation of the part of `values` that is independent from sample to sample: the median of the
/// absolute second differences over sqrt(6), scaled for a normal distribution (1.4826). Slow shapes cancel in
/// second differences, steps and spikes are too few to move a median. Noise that is slower than a few samples
/// is not seen. Source: median absolute deviation (Hampel 1974) of the second differences; their variance is
/// 6 times that of white noise.
/// @param values  in sequence of time, evenly spaced
/// @return 0 for fewer than 3 values
double sample_noise(const Eigen::VectorXd& values);

}  // namespace ballbar
