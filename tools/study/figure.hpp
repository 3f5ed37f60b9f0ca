#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace roadbalance {

struct Axis {
  std::string label;  ///< with the unit
  bool logarithmic = false;
};

/// Points (x[i], y[i]) joined in this order; one that the axes cannot show (no number, not positive on a
/// logarithmic axis) interrupts the line.
struct Series {
  std::string name;
  std::vector<double> x, y;
  bool dashed = false;
  bool markers = true;
};

/// One picture of a study.
struct Figure {
  std::string name;  ///< of the file, without .svg
  std::string title;
  Axis x, y;
  std::vector<Series> series;
};

/// Share of the values, in percent, that is no larger than x in size: from 0 to where the largest is.  Values
/// that are not finite are larger than all.
Series distribution(const std::string& name, const std::vector<double>& values);

/// The picture as a self-contained SVG: no fonts, scripts or files from elsewhere; black on white or white
/// on black as the reader's screen prefers.
std::string svg(const Figure& figure);

/// Writes each as FOLDER/NAME.svg.
/// @throws std::system_error
void write_figures(const std::vector<Figure>& figures, const std::filesystem::path& folder);

}  // namespace roadbalance
