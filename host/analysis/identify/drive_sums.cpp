#include "host/analysis/identify/drive_sums.hpp"

#include <complex>
#include <cstddef>
#include <map>
#include <stdexcept>

#include "host/analysis/identify/byte_archive.hpp"

namespace roadbalance {
namespace {

template <typename Archive, typename Derived>
void matrix(Archive& archive, Eigen::MatrixBase<Derived>& m) {
  using Scalar = typename Derived::Scalar;
  archive.numbers(reinterpret_cast<double*>(m.derived().data()),
                  static_cast<std::size_t>(m.size()) * sizeof(Scalar) / sizeof(double));
}

template <typename Archive>
void complex(Archive& archive, std::complex<double>& value) {
  archive.numbers(reinterpret_cast<double*>(&value), 2);
}

template <typename Archive, typename Scalar>
void instrument(Archive& archive, InstrumentMoments<Scalar>& m) {
  matrix(archive, m.w2);
  matrix(archive, m.w1);
  matrix(archive, m.w0);
}

template <typename Archive>
void moments(Archive& archive, DriveMoments& m) {
  archive(m.seconds);
  archive(m.speed_seconds);
  archive(m.sections);
  for (auto& each : m.chassis) instrument(archive, each);
  archive.numbers(m.chassis_power.data(), m.chassis_power.size());
  for (DriveMoments::Wheel& wheel : m.wheel) {
    instrument(archive, wheel.tyre);
    complex(archive, wheel.tyre_unbalance);
  }
  matrix(archive, m.harmonic.normal);
  for (auto& row : m.harmonic.right)
    for (auto& each : row) instrument(archive, each);
  matrix(archive, m.body.normal);
  matrix(archive, m.body.right);
}

template <typename Archive>
void one_class(Archive& archive, SpeedClasses::Class& each) {
  for (DriveMoments& group : each.group) moments(archive, group);
  moments(archive, each.total);
}

/// Of any size.
template <typename Archive, typename Scalar, int Rows, int Columns>
void resized(Archive& archive, Eigen::Matrix<Scalar, Rows, Columns>& m) {
  auto rows = static_cast<std::uint64_t>(m.rows()), columns = static_cast<std::uint64_t>(m.cols());
  archive(rows);
  archive(columns);
  if (rows > archive.most(sizeof(Scalar)) || columns > archive.most(sizeof(Scalar)) ||
      rows * columns > archive.most(sizeof(Scalar)))
    throw std::length_error("too short");
  m.resize(static_cast<Eigen::Index>(rows), static_cast<Eigen::Index>(columns));
  matrix(archive, m);
}

template <typename Archive>
void resized(Archive& archive, Eigen::ArrayXd& values) {
  Eigen::VectorXd all = values;
  resized(archive, all);
  values = all;
}

template <typename Archive>
void spectra(Archive& archive, SpectralMoments& m) {
  resized(archive, m.frequency_hz);
  resized(archive, m.count);
  archive(m.segments);
  archive(m.delay_seconds);
  for (SpectralMoments::Spectra* const each : {&m.same, &m.delayed}) {
    std::uint64_t bins = each->size();
    archive(bins);
    if (bins > archive.most(sizeof(double))) throw std::length_error("too short");
    each->resize(bins);
    for (Eigen::MatrixXcd& bin : *each) resized(archive, bin);
  }
}

template <typename Archive>
void lines(Archive& archive, LineMoments& m) {
  matrix(archive, m.normal);
  for (Eigen::MatrixXcd& right : m.right) resized(archive, right);
  archive(m.seconds);
  matrix(archive, m.turned_rad);
}

/// Values by class of speed: those there are, or as many as the archive holds.
template <typename Archive, typename Value, typename One>
void by_speed(Archive& archive, std::map<int, Value>& all, const One& one) {
  std::uint64_t count = all.size();
  archive(count);
  auto next = all.begin();
  while (count-- > 0) {
    int speed = next == all.end() ? 0 : next->first;
    archive(speed);
    one(all[speed]);
    if (next != all.end()) ++next;
  }
}

template <typename Archive>
void posterior(Archive& archive, PosteriorSums& sums) {
  by_speed(archive, sums.speed, [&archive](PosteriorSums::Speed& speed) {
    spectra(archive, speed.spectra);
    lines(archive, speed.lines);
  });
  archive(sums.cut_s);
}

template <typename Archive>
void drift(Archive& archive, PhaseDrift& seen) {
  for (auto& row : seen.seen)
    for (auto& cells : row)
      for (std::size_t k = 0; k < cells.size(); ++k) {
        bool set = cells.test(k);
        archive(set);
        cells.set(k, set);
      }
}

template <typename Archive>
void rest(Archive& archive, DriveSums& sums) {
  posterior(archive, sums.posterior);
  drift(archive, sums.drift);
  archive(sums.time_ns);
  archive(sums.state);
  archive.text(sums.refusal);
  archive.numbers(sums.common_sigma_rad.data(), sums.common_sigma_rad.size());
}

}  // namespace

std::vector<char> encode(const DriveSums& of) {
  DriveSums sums = of;
  ByteWriter writer;
  double width_m_s = sums.classes.width_m_s();
  writer(width_m_s);
  std::map<int, SpeedClasses::Class> classes = sums.classes.classes();
  by_speed(writer, classes, [&writer](SpeedClasses::Class& each) { one_class(writer, each); });
  rest(writer, sums);
  return writer.bytes;
}

std::optional<DriveSums> decode_drive_sums(std::span<const char> bytes) {
  ByteReader reader(bytes);
  try {
    double width_m_s = 0.0;
    reader(width_m_s);
    std::map<int, SpeedClasses::Class> classes;
    by_speed(reader, classes, [&reader](SpeedClasses::Class& each) { one_class(reader, each); });
    DriveSums sums(width_m_s);
    sums.classes = SpeedClasses(width_m_s, classes);
    rest(reader, sums);
    if (!reader.ended()) return std::nullopt;
    return sums;
  } catch (const std::length_error&) {
    return std::nullopt;
  }
}

}  // namespace roadbalance
