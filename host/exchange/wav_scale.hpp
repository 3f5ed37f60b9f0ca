#pragma once

namespace roadbalance {

/// A sample of a WAV file is its counts times this: counts of 24 bits, and a reference of 1.0, which is a
/// count more, stay whole within 32 bits.
inline constexpr int kWavSamplesPerCount = 128;

/// Added to what stands for no sample, the counts nearest below silence: no sample is that.
inline constexpr int kWavMissing = 1;

}  // namespace roadbalance
