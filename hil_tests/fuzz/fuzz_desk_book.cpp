#include <stdexcept>
#include <string>

#include "common/bus/wire_text.hpp"
#include "common/record/test/simulated_disk.hpp"
#include "hil_tests/fuzz/property.hpp"
#include "host/recorder/desk_book.hpp"

// The file in which a recorder that takes requests remembers them.
namespace roadbalance {
namespace {

using fuzz::require;
using test::SimulatedDisk;

constexpr const char* kFolder = "/recordings";

fuzz::Reached recordings("a recording under way"), ended("a recording that ended"), set_ups("a set-up"),
    rests("a rest"), overs("a recording that is over");

void count(const DeskBook& book) {
  if (book.under_way) recordings.count();
  if (book.finished && !book.finished->receipt.empty()) ended.count();
  if (book.set_up) set_ups.count();
  if (!book.rest.empty()) rests.count();
  if (!book.over.empty()) overs.count();
}

void check(const std::vector<std::uint8_t>& bytes) {
  const std::string file = std::string(kFolder) + "/" + kDeskBookFile;
  SimulatedDisk disk;
  disk.mkdir(kFolder, 0755);
  disk.put(file, bytes);
  DeskBook book;
  try {
    book = read_desk_book(kFolder, disk);
  } catch (const std::runtime_error& error) {
    const std::string_view said = error.what();
    require(said.starts_with(file + ": "), "a refusal names the file");
    require(wire_text::is_plain_text(said), "a refusal repeats nothing that a terminal would obey");
    require(disk.content(file) == bytes, "what is refused stays as it is");
    return;
  }
  count(book);
  if (book.under_way) require(fault_of_name(book.under_way->name).empty(), "a recording is a name");
  if (book.under_way) static_cast<void>(first_incarnation(*book.under_way, book.over));
  for (const Rest& rest : book.rest) require(fault_of_name(rest.recording).empty(), "so is that of a rest");
  for (const Over& over : book.over) require(fault_of_name(over.recording).empty(), "and one that is over");
  write_desk_book(kFolder, book, disk);
  const DeskBook again = read_desk_book(kFolder, disk);
  require(text_of(again) == text_of(book), "what was read is written so that it is read again alike");
}

}  // namespace
}  // namespace roadbalance

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  roadbalance::check({data, data + size});
  return 0;
}
