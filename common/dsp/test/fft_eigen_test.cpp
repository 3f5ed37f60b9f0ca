// The same properties of the transform that serves where FFTW is not wanted, proven in every build.
#include "common/dsp/test/fft_test.cpp"  // NOLINT(bugprone-suspicious-include)
