#include <algorithm>
#include <cstdio>

#include "common/multibody/model_text.hpp"

namespace roadbalance {
namespace {

std::string matrix(const std::string& name, const ExpressionMatrix& m) {
  if (m.columns() == 0 || m.rows() == 0) return "";
  std::string text = name + " &= \\begin{bmatrix}\n";
  for (std::size_t i = 0; i < m.rows(); ++i) {
    for (std::size_t j = 0; j < m.columns(); ++j) text += (j ? " & " : "  ") + m(i, j).latex();
    text += i + 1 < m.rows() ? " \\\\\n" : "\n";
  }
  return text + "\\end{bmatrix} \\\\\n";
}

std::string column(const std::string& name, const std::vector<std::string>& entries) {
  if (entries.empty()) return "";
  std::string text = name + " &= \\begin{bmatrix}";
  for (std::size_t i = 0; i < entries.size(); ++i) text += (i ? " & " : " ") + entries[i];
  return text + " \\end{bmatrix}^\\mathsf{T} \\\\\n";
}

std::string written(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", value);
  return text;
}

}  // namespace

std::string latex_text(const Equations& e) {
  std::vector<std::string> z, u, d;
  for (const NamedValue& one : e.coordinate) z.push_back(one.latex);
  for (const std::string& tyre : e.tyre) u.push_back("u_{" + latex_name(tyre) + "}");
  for (const std::string& rotor : e.rotor) {
    d.push_back("\\sin\\alpha_{" + latex_name(rotor) + "}");
    d.push_back("\\cos\\alpha_{" + latex_name(rotor) + "}");
  }
  std::string text = "% " + e.name + ": M z'' + P z' + Q z = T d + S u + Sd u', made by rb model --latex\n";
  text += "\\begin{align*}\n";
  text += "M \\ddot z + P \\dot z + Q z &= T d + S u + \\dot S \\dot u \\\\\n";
  text += column("z", z) + column("u", u) + column("d", d);
  text += matrix("M", e.M) + matrix("P", e.P) + matrix("Q", e.Q) + matrix("S", e.S);
  text += matrix("\\dot S", e.Sd) + matrix("T / \\Omega^2", e.T);
  for (const auto* kind : {&e.length, &e.tension})
    for (const Equations::AtRest& one : *kind)
      text += one.symbol.latex() + " &= " + one.value.latex() + " \\\\\n";
  if (!e.sensor.empty()) {
    std::vector<std::string> y;
    for (const std::string& sensor : e.sensor) y.push_back(latex_name(sensor));
    text +=
        "y &= C \\ddot z + G z \\\\\n" + column("y", y) + matrix("C", e.acceleration) + matrix("G", e.tilt);
  }
  const auto last = text.rfind(" \\\\\n");
  text.erase(last, 3);
  text += "\\end{align*}\n";
  for (const auto* kind : {&e.parameter, &e.geometry})
    for (const NamedValue& one : *kind)
      text += "% $" + one.latex + "$ = " + written(one.value) + "  " + one.name + "\n";
  return text;
}

}  // namespace roadbalance
