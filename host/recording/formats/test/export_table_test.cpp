#include "host/recording/formats/export_table.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "common/config/section.hpp"
#include "common/test/source.hpp"
#include "host/recording/formats/candump_writer.hpp"
#include "host/recording/formats/survey.hpp"

// A channel has the same place in every recording of a car.
namespace roadbalance {
namespace {

constexpr std::int64_t kSecond_ns = 1'000'000'000;

VehicleConfig car() {
  return VehicleConfig::read_file(test::source_path("sim/demo/vehicle.toml"));
}

/// A survey of nodes in the order in which they began, one after the other or, on one grid, at once.
RecordingSurvey survey_of(const VehicleConfig& vehicle, const std::vector<std::int32_t>& nodes) {
  RecordingSurvey survey{.vehicle = vehicle};
  for (const std::int32_t node : nodes)
    survey.span.push_back({.node = node,
                           .epoch = 100 + node,
                           .next_scan = 2000,
                           .samples = 2000,
                           .period_ps = 500'000'000,
                           .last_ns = kSecond_ns});
  return survey;
}

std::vector<std::string> names(const ExportGroup& group) {
  std::vector<std::string> all;
  for (const ExportChannel& channel : group.channel) all.push_back(channel.name);
  return all;
}

/// Nodes and their channels as they stand in the file.
std::vector<std::string> in_order_of(const VehicleConfig& vehicle) {
  std::vector<std::string> all;
  for (const NodeConfig& node : vehicle.node) {
    for (const ChannelConfig& channel : node.channel)
      if (channel.role != ChannelRole::kUnused) all.push_back(channel.name);
    for (int line = 0; line < kEncoderLines; ++line)
      if (const WheelConfig* const wheel = vehicle.wheel_at(node, line)) {
        all.push_back(wheel->name + "_angle_sin");
        all.push_back(wheel->name + "_angle_cos");
      }
  }
  return all;
}

TEST(ExportTable, TheFileGivesTheOrderWhicheverNodeCameFirst) {
  const VehicleConfig vehicle = car();
  ASSERT_EQ(vehicle.node.size(), 2U);
  const std::int32_t first = vehicle.node[0].id, second = vehicle.node[1].id;
  const std::vector<std::string> expected = in_order_of(vehicle);
  std::string dbc;
  for (const auto& nodes : {std::vector{first, second}, std::vector{second, first}}) {
    const ExportTable table = make_table(survey_of(vehicle, nodes));
    ASSERT_EQ(table.group.size(), 1U);
    EXPECT_EQ(names(table.group[0]), expected);
    for (std::size_t c = 0; c < expected.size(); ++c) EXPECT_EQ(table.group[0].channel[c].number, c);
    if (dbc.empty()) dbc = candump_dbc(table);
    EXPECT_EQ(candump_dbc(table), dbc);
  }
}

TEST(ExportTable, GroupsOfNodesWithClocksOfTheirOwnStandInThatOrderToo) {
  const VehicleConfig vehicle = car();
  RecordingSurvey survey = survey_of(vehicle, {vehicle.node[1].id, vehicle.node[0].id});
  for (RecordedSpan& span : survey.span) {
    span.first_fit = ClockFit{.node = span.node, .epoch = span.epoch};
    span.last_host_ns = kSecond_ns;
  }
  const ExportTable table = make_table(survey);
  ASSERT_EQ(table.group.size(), 2U);
  EXPECT_EQ(table.group[0].name, vehicle.node[0].name);
  EXPECT_EQ(table.group[1].name, vehicle.node[1].name);
}

TEST(ExportTable, AnAbsentNodeMovesNobody) {
  const VehicleConfig vehicle = car();
  std::map<std::string, std::size_t> number;
  const ExportTable both = make_table(survey_of(vehicle, {vehicle.node[0].id, vehicle.node[1].id}));
  for (const ExportChannel& channel : both.group[0].channel) number[channel.name] = channel.number;
  const ExportTable rear = make_table(survey_of(vehicle, {vehicle.node[1].id}));
  ASSERT_FALSE(rear.group.at(0).channel.empty());
  for (const ExportChannel& channel : rear.group[0].channel)
    EXPECT_EQ(channel.number, number.at(channel.name));
}

TEST(ExportTable, NamedChannelsStandAsTheyAreNamedAndKeepTheirNumbers) {
  const VehicleConfig vehicle = car();
  const NodeConfig &front = vehicle.node[0], &rear = vehicle.node[1];
  ExportTable table = make_table(survey_of(vehicle, {front.id, rear.id}));
  const auto before = table.group[0];
  const std::string last = front.channel[2].name, first = front.channel[0].name;
  select({.channels = {last, rear.name, first, last}}, table);
  const auto& found = table.group[0];
  const std::vector<std::string> all = names(found);
  EXPECT_EQ(all.front(), last);
  EXPECT_EQ(all.back(), first);
  EXPECT_EQ(all[1], rear.channel[0].name);
  EXPECT_EQ(std::ranges::count(all, last), 1);
  for (const ExportChannel& channel : found.channel)
    EXPECT_EQ(channel.number, std::ranges::find(before.channel, channel.name, &ExportChannel::name)->number);
  // Each column is filled from the converter that it had.
  for (const ExportPart& part : found.part) {
    const auto was = std::ranges::find(before.part, part.node, &ExportPart::node);
    for (const auto& [converter, column] : part.column) {
      const auto same = std::ranges::find(was->column, converter, &ExportPart::Column::converter);
      EXPECT_EQ(before.channel[same->column].name, found.channel[column].name);
    }
  }
}

TEST(ExportTable, ANameThatTwoNodesHaveIsTheSameWhoeverWasRecorded) {
  VehicleConfig vehicle = car();
  const NodeConfig &front = vehicle.node[0], &rear = vehicle.node[1];
  const std::string other = front.channel[1].name;
  for (NodeConfig& node : vehicle.node) node.channel[0].name = "up";
  const auto first_name = [&](const std::vector<std::int32_t>& nodes, const std::string& node) {
    const ExportTable table = make_table(survey_of(vehicle, nodes));
    return std::ranges::find(table.group.at(0).channel, node, &ExportChannel::node)->name;
  };
  EXPECT_EQ(first_name({front.id, rear.id}, front.name), front.name + "_up");
  EXPECT_EQ(first_name({front.id}, front.name), front.name + "_up");
  EXPECT_EQ(first_name({front.id, rear.id}, rear.name), rear.name + "_up");
  EXPECT_EQ(first_name({rear.id}, rear.name), rear.name + "_up");
  // The description of both and of one has the same signal for the same identifier.
  const std::string both = candump_dbc(make_table(survey_of(vehicle, {front.id, rear.id})));
  const std::string one = candump_dbc(make_table(survey_of(vehicle, {rear.id})));
  const std::string signal = "SG_ " + rear.name + "_up :";
  const auto message_of = [&](const std::string& dbc) {
    const auto at = dbc.find(signal), begin = dbc.rfind("BO_ ", at);
    return dbc.substr(begin, dbc.find("\n\n", at) - begin);
  };
  ASSERT_NE(both.find(signal), std::string::npos);
  ASSERT_NE(one.find(signal), std::string::npos);
  EXPECT_EQ(message_of(one), message_of(both));
  EXPECT_NE(both.find("SG_ " + other + " :"), std::string::npos) << "others keep their names";
}

TEST(ExportTable, AnotherScaleIsAnotherMeaning) {
  const VehicleConfig vehicle = car();
  const std::vector<std::int32_t> nodes{vehicle.node[0].id, vehicle.node[1].id};
  const auto meaning = make_table(survey_of(vehicle, nodes)).meaning_crc32c;
  EXPECT_EQ(make_table(survey_of(vehicle, {vehicle.node[1].id})).meaning_crc32c, meaning);
  for (const auto change : {+[](VehicleConfig& v) { std::swap(v.node[0], v.node[1]); },
                            +[](VehicleConfig& v) { v.node[1].channel[0].name += "2"; },
                            +[](VehicleConfig& v) { v.node[0].channel[1].offset_counts += 1.0; },
                            +[](VehicleConfig& v) { v.node[0].channel[0].scale_m_s2_per_count *= 2.0; }}) {
    VehicleConfig other = vehicle;
    change(other);
    EXPECT_NE(make_table(survey_of(other, nodes)).meaning_crc32c, meaning);
  }
}

}  // namespace
}  // namespace roadbalance
