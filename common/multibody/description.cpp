#include "common/multibody/description.hpp"

#include <algorithm>
#include <set>
#include <stdexcept>
#include <utility>

#include "common/config/section.hpp"
#include "common/config/text_file.hpp"

namespace roadbalance {
namespace {

constexpr std::size_t kMost = 64;  ///< of any kind of thing, and of names of a kind

/// Reads the tables in the order in which they name one another.
class Reader {
 public:
  explicit Reader(Section root) : root_(std::move(root)) {}

  Description all() {
    d_.name = root_.text("name");
    if (d_.name.empty() || d_.name.size() > 60) root_.fail("name", "allowed: 1 .. 60 characters");
    d_.gravity_m_s2 = root_.number_or("gravity_m_s2", {0, 100}, d_.gravity_m_s2);
    names();
    each("body", [this](Section& table) { body(table); });
    if (d_.body.empty()) root_.fail("body", "missing; allowed: at least one [[body]]");
    each("point", [this](Section& table) {
      d_.point.push_back({new_name(table), body_of(table, "body"), known(table, "position")});
    });
    each("spring", [this](Section& table) {
      d_.spring.push_back({new_name(table), stretch(table), formula(table, "stiffness")});
    });
    each("damper", [this](Section& table) {
      d_.damper.push_back({new_name(table), stretch(table), formula(table, "damping")});
    });
    each("stabiliser", [this](Section& table) {
      d_.stabiliser.push_back(
          {new_name(table), pair_of(table, "springs", d_.spring), formula(table, "stiffness")});
    });
    each("tyre", [this](Section& table) {
      d_.tyre.push_back({new_name(table), point_of(table), formula(table, "stiffness"),
                         table.has("damping") ? formula(table, "damping") : Formula()});
    });
    each("unbalance", [this](Section& table) { unbalance(table); });
    each("sensor", [this](Section& table) {
      d_.sensor.push_back({new_name(table), point_of(table), known(table, "direction")});
    });
    root_.finish();
    return std::move(d_);
  }

 private:
  template <typename Read>
  void each(const std::string& key, const Read& read) {
    auto tables = root_.sections(key);
    if (tables.size() > kMost) root_.fail(key, "allowed: at most 64 of them");
    used_.clear();
    for (Section& table : tables) {
      read(table);
      table.finish();
    }
  }

  void names() {
    for (const std::string& name : root_.texts_or("coordinates", {})) {
      check_new(root_, "coordinates", name);
      d_.coordinate.push_back({name, 0.0, name});
      coordinates_.insert(name);
    }
    if (d_.coordinate.empty())
      root_.fail("coordinates", std::string(root_.has("coordinates") ? "is empty" : "missing") +
                                    "; allowed: 1 .. 16 names in [ ]");
    values("parameter", d_.parameter);
    values("geometry", d_.geometry);
    auto latex = root_.section_if("latex");
    for (auto* kind : {&d_.coordinate, &d_.parameter, &d_.geometry})
      for (NamedValue& one : *kind) {
        one.latex = latex_name(one.name);
        if (!latex) continue;
        one.latex = latex->text_or(one.name, one.latex);
        if (latex->has(one.name) && (one.latex.empty() || one.latex.size() > 60))
          latex->fail(one.name, "allowed: 1 .. 60 characters");
      }
    if (latex) latex->finish();
  }

  void values(const std::string& key, std::vector<NamedValue>& into) {
    auto table = root_.section_if(key);
    if (!table) return;
    for (const std::string& name : table->keys()) {
      check_new(*table, name, name);
      into.push_back({name, table->number(name, kAnyNumber), name});
    }
    if (into.size() > kMost) root_.fail(key, "allowed: at most 64 of them");
  }

  void check_new(const Section& at, const std::string& key, const std::string& name) {
    if (!is_formula_name(name))
      at.fail(key, "\"" + name +
                       "\" cannot be a name; allowed: lower-case letters, digits and _, a letter first, at "
                       "most 40, no word of C++");
    if (!names_.insert(name).second) at.fail(key, "\"" + name + "\" stands twice");
  }

  std::string new_name(Section& table) {
    const std::string name = table.text("name");
    if (!is_formula_name(name))
      table.fail("name", "allowed: lower-case letters, digits and _, a letter first");
    if (!used_.insert(name).second) table.fail("name", "\"" + name + "\" stands twice");
    return name;
  }

  Formula checked(const Section& table, const std::string& key, const std::string& text, bool moves) const {
    try {
      Formula formula(text);
      for (const Formula::Step& step : formula.steps())
        if (step.kind == Formula::Kind::kName) {
          if (!names_.contains(step.name)) table.fail(key, "nothing is named " + step.name);
          if (!moves && coordinates_.contains(step.name))
            table.fail(key, step.name + " is a coordinate; allowed: parameters and geometry");
        }
      return formula;
    } catch (const std::invalid_argument& error) {
      table.fail(key, "\"" + text.substr(0, 40) + "\" " + error.what());
    }
  }

  Formula formula(Section& table, const std::string& key, bool moves = false) const {
    return checked(table, key, table.formula(key), moves);
  }
  std::vector<Formula> formulas(Section& table, const std::string& key, std::size_t size, bool moves) const {
    std::vector<Formula> result;
    for (const std::string& text : table.formulas(key, size))
      result.push_back(checked(table, key, text, moves));
    return result;
  }
  std::array<Formula, 3> three(Section& table, const std::string& key, bool moves) const {
    const auto list = formulas(table, key, 3, moves);
    return {list[0], list[1], list[2]};
  }
  std::array<Formula, 3> known(Section& table, const std::string& key) const {
    return three(table, key, false);
  }

  template <typename Thing>
  int place(const Section& table, const std::string& key, const std::string& name,
            const std::vector<Thing>& among) const {
    const auto found = std::ranges::find(among, name, &Thing::name);
    if (found != among.end()) return static_cast<int>(found - among.begin());
    std::string names;
    for (const Thing& thing : among) names += (names.empty() ? "" : ", ") + thing.name;
    table.fail(
        key, "there is no \"" + name.substr(0, 40) + "\"; allowed: " + (names.empty() ? "none yet" : names));
  }
  template <typename Thing>
  std::array<int, 2> pair_of(Section& table, const std::string& key, const std::vector<Thing>& among) const {
    const auto list = table.texts_or(key, {});
    if (list.size() != 2 || list[0] == list[1]) table.fail(key, "allowed: two names in [ ]");
    return {place(table, key, list[0], among), place(table, key, list[1], among)};
  }
  int body_of(Section& table, const std::string& key) const {
    const std::string name = table.text_or(key, "ground");
    return name == "ground" ? BodyDescription::kGround : place(table, key, name, d_.body);
  }
  int point_of(Section& table) const { return place(table, "point", table.text("point"), d_.point); }

  void body(Section& table) {
    BodyDescription b;
    b.name = new_name(table);
    if (b.name == "ground") table.fail("name", "the ground is there already");
    b.on = body_of(table, "on");
    b.position = three(table, "position", true);
    b.axes = table.text_or("axes", "");
    if (b.axes.size() > 6 || b.axes.find_first_not_of("xyz") != std::string::npos)
      table.fail("axes", "allowed: up to six of the letters x, y, z");
    if (!b.axes.empty()) b.angle = formulas(table, "angles", b.axes.size(), true);
    b.mass = table.has("mass") ? formula(table, "mass") : Formula();
    if (table.has("inertia")) b.inertia = known(table, "inertia");
    if (table.has("products_of_inertia")) b.product = known(table, "products_of_inertia");
    d_.body.push_back(std::move(b));
  }

  StretchDescription stretch(Section& table) const {
    StretchDescription s;
    if (table.has("stretch")) {
      s.formula = formula(table, "stretch", true);
      return s;
    }
    if (!table.has("between")) table.fail("between", "missing; allowed: two points, or stretch = a formula");
    s.point = pair_of(table, "between", d_.point);
    s.along = table.has("direction");
    if (s.along) s.direction = known(table, "direction");
    return s;
  }

  void unbalance(Section& table) {
    UnbalanceDescription u{new_name(table), table.text("rotor"), point_of(table), {}, {}};
    if (!is_formula_name(u.rotor))
      table.fail("rotor", "allowed: lower-case letters, digits and _, a letter first");
    const auto moment = formulas(table, "moment", 2, false);
    u.cosine = moment[0];
    u.sine = moment[1];
    d_.unbalance.push_back(std::move(u));
  }

  Section root_;
  Description d_;
  std::set<std::string> names_, coordinates_;
  std::set<std::string> used_;  ///< names of the kind that is being read
};

}  // namespace

std::string latex_name(const std::string& name) {
  std::string text = "\\mathrm{";
  for (const char c : name) text += c == '_' ? std::string("\\_") : std::string(1, c);
  return text + "}";
}

Description Description::parse(const std::string& text, const std::string& name_for_errors) {
  return Reader(Section::parse_text(text, name_for_errors)).all();
}

Description Description::read_file(const std::string& path) {
  return parse(read_text_file(path, Section::kMostBytes), path);
}

std::vector<std::string> Description::rotors() const {
  std::vector<std::string> names;
  for (const UnbalanceDescription& plane : unbalance)
    if (std::ranges::find(names, plane.rotor) == names.end()) names.push_back(plane.rotor);
  return names;
}

}  // namespace roadbalance
