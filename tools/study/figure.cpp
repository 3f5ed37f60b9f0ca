#include "tools/study/figure.hpp"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <limits>
#include <system_error>

#include "common/text/markup.hpp"

namespace roadbalance {
namespace {

constexpr double kWidth = 860, kHeight = 500;
constexpr double kLeft = 80, kRight = 640, kTop = 44, kBottom = 440;  ///< of the plot; the legend is beside
constexpr int kColours = 8;
/// Colours of middle lightness, so that they stand out from white and from black.
constexpr const char* kStyle =
    "svg{--ink:#1f2328;--paper:#ffffff;--grid:#d8dee4}"
    "@media (prefers-color-scheme:dark){svg{--ink:#e6edf3;--paper:#0d1117;--grid:#30363d}}"
    "text{fill:var(--ink);font:13px sans-serif}.title{font-size:15px;font-weight:bold}"
    ".paper{fill:var(--paper)}.grid{stroke:var(--grid)}.frame{stroke:var(--ink);fill:none}"
    ".line{fill:none;stroke-width:1.8}"
    ".c0{stroke:#3b82f6;color:#3b82f6}.c1{stroke:#e5534b;color:#e5534b}.c2{stroke:#2da44e;color:#2da44e}"
    ".c3{stroke:#bf8700;color:#bf8700}.c4{stroke:#a371f7;color:#a371f7}.c5{stroke:#1b9aaa;color:#1b9aaa}"
    ".c6{stroke:#d16ba5;color:#d16ba5}.c7{stroke:#8b949e;color:#8b949e}.dot{fill:currentColor}";

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", value);
  return text;
}

/// One axis: what it reaches over, where its ticks are, and where a value lies.
class Scale {
 public:
  Scale(const Axis& axis, double from, double to) : logarithmic_(axis.logarithmic), from_(from), to_(to) {}

  bool shows(double value) const { return std::isfinite(value) && (!logarithmic_ || value > 0.0); }
  void include(double value) {
    if (!shows(value)) return;
    low_ = std::min(low_, value);
    high_ = std::max(high_, value);
  }
  /// After the last include().
  void finish() {
    if (low_ > high_) low_ = high_ = 1.0;
    if (logarithmic_) {
      low_ = std::pow(10.0, std::floor(3.0 * std::log10(low_) - 0.05) / 3.0);
      high_ = std::pow(10.0, std::ceil(3.0 * std::log10(high_) + 0.05) / 3.0);
      return;
    }
    const double margin = high_ > low_ ? 0.05 * (high_ - low_) : std::max(1.0, 0.1 * std::abs(high_));
    if (low_ < 0.0 || low_ > 0.5 * high_)
      low_ -= margin;
    else
      low_ = 0.0;
    high_ += margin;
  }
  double place(double value) const {
    const auto of = [&](double v) { return logarithmic_ ? std::log(v) : v; };
    return from_ + (to_ - from_) * (of(value) - of(low_)) / (of(high_) - of(low_));
  }
  std::vector<double> ticks() const {
    std::vector<double> result;
    if (logarithmic_) {
      for (double decade = std::pow(10.0, std::floor(std::log10(low_))); decade <= high_; decade *= 10.0)
        for (const double step : {1.0, 2.0, 5.0})
          if (decade * step >= low_ * 0.999 && decade * step <= high_ * 1.001)
            result.push_back(decade * step);
      return result;
    }
    const double rough = (high_ - low_) / 6.0;
    const double decade = std::pow(10.0, std::floor(std::log10(rough)));
    const double part = rough / decade;
    const double step = decade * (part < 1.5 ? 1.0 : part < 3.5 ? 2.0 : part < 7.5 ? 5.0 : 10.0);
    for (double k = std::ceil(low_ / step); k * step <= high_; k += 1.0) result.push_back(k * step);
    return result;
  }

 private:
  bool logarithmic_;
  double from_, to_;
  double low_ = std::numeric_limits<double>::infinity(), high_ = -std::numeric_limits<double>::infinity();
};

std::string text_at(double x, double y, const std::string& text, const std::string& attributes = "") {
  return "<text x=\"" + number(x) + "\" y=\"" + number(y) + "\" " + attributes + ">" + markup_text(text) +
         "</text>\n";
}

std::string line_between(double x1, double y1, double x2, double y2, const std::string& look) {
  return "<line x1=\"" + number(x1) + "\" y1=\"" + number(y1) + "\" x2=\"" + number(x2) + "\" y2=\"" +
         number(y2) + "\" class=\"" + look + "\"/>\n";
}

std::string axes(const Figure& figure, const Scale& x, const Scale& y) {
  std::string result;
  for (const double tick : x.ticks()) {
    result += line_between(x.place(tick), kTop, x.place(tick), kBottom, "grid");
    result += text_at(x.place(tick), kBottom + 18, number(tick), "text-anchor=\"middle\"");
  }
  for (const double tick : y.ticks()) {
    result += line_between(kLeft, y.place(tick), kRight, y.place(tick), "grid");
    result += text_at(kLeft - 8, y.place(tick) + 4, number(tick), "text-anchor=\"end\"");
  }
  result += "<rect class=\"frame\" x=\"" + number(kLeft) + "\" y=\"" + number(kTop) + "\" width=\"" +
            number(kRight - kLeft) + "\" height=\"" + number(kBottom - kTop) + "\"/>\n";
  result += text_at(0.5 * (kLeft + kRight), kHeight - 16, figure.x.label, "text-anchor=\"middle\"");
  const std::string middle = number(0.5 * (kTop + kBottom));
  return result + "<text transform=\"translate(20 " + middle + ") rotate(-90)\" text-anchor=\"middle\">" +
         markup_text(figure.y.label) + "</text>\n";
}

std::string curve(const Series& series, int index, const Scale& x, const Scale& y) {
  const std::string colour = "c" + std::to_string(index % kColours);
  const std::string dashes = series.dashed || index >= kColours ? " stroke-dasharray=\"6 4\"" : "";
  std::string path, dots;
  bool down = false;
  for (std::size_t i = 0; i < series.x.size(); ++i) {
    if (!x.shows(series.x[i]) || !y.shows(series.y[i])) {
      down = false;
      continue;
    }
    const std::string px = number(x.place(series.x[i])), py = number(y.place(series.y[i]));
    path += (down ? " L" : " M") + px + " " + py;
    down = true;
    if (series.markers)
      dots += "<circle class=\"dot " + colour + "\" cx=\"" + px + "\" cy=\"" + py + "\" r=\"3\"/>\n";
  }
  if (path.empty()) return "";
  return "<path class=\"line " + colour + "\"" + dashes + " d=\"" + path.substr(1) + "\"/>\n" + dots;
}

std::string legend(const Figure& figure) {
  std::string result;
  for (std::size_t i = 0; i < figure.series.size(); ++i) {
    const double y = kTop + 8 + 20.0 * static_cast<double>(i);
    const bool dashed = figure.series[i].dashed || i >= kColours;
    result += "<path class=\"line c" + std::to_string(i % kColours) + "\"" +
              (dashed ? " stroke-dasharray=\"6 4\"" : "") + " d=\"M" + number(kRight + 14) + " " + number(y) +
              " h24\"/>\n";
    result += text_at(kRight + 44, y + 4, figure.series[i].name);
  }
  return result;
}

}  // namespace

std::string svg(const Figure& figure) {
  Scale x(figure.x, kLeft, kRight), y(figure.y, kBottom, kTop);
  for (const Series& series : figure.series)
    for (std::size_t i = 0; i < series.x.size(); ++i)
      if (x.shows(series.x[i]) && y.shows(series.y[i])) x.include(series.x[i]), y.include(series.y[i]);
  x.finish();
  y.finish();
  const double height = std::max(kHeight, kTop + 30 + 20.0 * static_cast<double>(figure.series.size()));
  std::string result = "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 " + number(kWidth) + " " +
                       number(height) + "\" role=\"img\">\n<title>" + markup_text(figure.title) +
                       "</title>\n<style>" + kStyle + "</style>\n<rect class=\"paper\" width=\"100%\" " +
                       "height=\"100%\"/>\n";
  result += text_at(kLeft, 26, figure.title, "class=\"title\"");
  result += axes(figure, x, y);
  for (std::size_t i = 0; i < figure.series.size(); ++i)
    result += curve(figure.series[i], static_cast<int>(i), x, y);
  return result + legend(figure) + "</svg>\n";
}

Series distribution(const std::string& name, const std::vector<double>& values) {
  Series series{name, {}, {}, false, false};
  for (const double value : values)
    if (std::isfinite(value)) series.x.push_back(std::abs(value));
  std::sort(series.x.begin(), series.x.end());
  for (std::size_t i = 0; i < series.x.size(); ++i)
    series.y.push_back(100.0 * static_cast<double>(i + 1) / static_cast<double>(values.size()));
  return series;
}

void write_figures(const std::vector<Figure>& figures, const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder);
  for (const Figure& figure : figures) {
    const std::filesystem::path path = folder / (figure.name + ".svg");
    std::ofstream file(path);
    file << svg(figure);
    if (!file.flush()) throw std::system_error(errno, std::generic_category(), "write " + path.string());
  }
}

}  // namespace roadbalance
