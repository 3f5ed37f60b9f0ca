#pragma once

#include <deque>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "common/bus/operation.hpp"
#include "host/recorder/desk_book.hpp"
#include "host/recorder/recorder.hpp"

namespace roadbalance {

/// Obeys and answers requests; a pure state machine.  One recording at a time.
///
/// What was asked is in the book, on the disk, before it is done, and each request acts once, however often
/// it comes and whenever the recorder is killed: a start that was obeyed is answered as done by the recorder
/// that comes after, a stop goes on, a mark is noted again under the same number, a set-up is undone unless
/// it was done.  While the book's disk fails marks wait with the hands, and a stop alone does not.
class Desk {
 public:
  /// What it can do.
  struct Hands {
    std::function<void(const DeskBook&)> store;  ///< @throws std::system_error
    /// Something of this name, but for what a start left that came to nothing.  @throws std::system_error
    std::function<bool(const std::string& name)> exists;
    std::function<void(const UnderWay&)> begin;    ///< lets a recorder run on its folder
    std::function<void()> stop;                    ///< lets it come to its end
    std::function<void(NoteToRecord)> note;        ///< into the recording that runs; a mark when is_written()
    std::function<Answer(const Request&)> set_up;  ///< other operations; none is done yet
    std::function<AskedSetUp()> asked_set_up;      ///< what set_up() has just put under way ...
    std::function<void()> forget_set_up;           ///< ... and is not to do
    std::function<bool()> is_set_up_under_way;     ///< one of them has not come to its end
    std::function<Answer(const Request&)> read_mark;  ///< Operation::kReading
  };
  Desk(Hands hands, DeskBook book);

  struct Nodes {
    int there = 0;                          ///< could be recorded and set up
    std::vector<std::int32_t> returning{};  ///< have just left, with a recording or by themselves
  };
  /// A request that needs nodes which are about to return is answered as under way and not remembered:
  /// whoever asks repeats it until there is a last word.
  void take(const Request& request, std::int64_t utc_us, const Nodes& nodes);
  /// Begins a recording without a request.
  void begin(const std::string& name, std::int64_t utc_us);
  /// The program ends: so does a recording.
  void end();

  /// The recorder runs.
  /// @param has_samples    samples of a node are on the disk
  /// @param durable_marks  so are marks through this number
  void runs(bool has_samples, std::int32_t durable_marks, std::int64_t utc_us);
  /// The same of marks alone, at the end of a session.
  void marks_are_durable(std::int32_t through);
  /// It has come to its end as told, with these receipts; nodes that were cut off hold the rest of it.
  /// @return rests of recordings before that are not fetched any more, for the book has no room: to be
  /// declared
  /// @param last_incarnation  of its recorders
  std::vector<Rest> ended(std::vector<Receipt> receipts, std::vector<Rest> rests, std::int64_t utc_us,
                          std::int64_t last_incarnation);
  /// Nodes hold these, too, of a recording that is over: nobody knew so far.  Those for which the book has no
  /// room are to be said again.
  void owe(const std::vector<Rest>& rests);
  /// Nothing of these is to be fetched any more.
  /// @param complete  the receipts of their recording as they are now, made of those before
  void settled(const std::vector<Rest>& rests,
               const std::function<std::vector<Receipt>(const std::vector<Receipt>&)>& complete);
  /// It has ended with an error and is to be begun again; one that has never run is given up.
  void failed(const std::string& why, bool has_run, std::int64_t utc_us);
  /// Begins it again.
  void again();
  /// Once more what the disk would not take, if there is something: to be called about once a second.  Until
  /// then a recorder that is killed leaves an older book.
  void write_again();
  /// So the disk has it.
  bool is_written() const { return is_written_; }
  /// What became of something passed to Hands::set_up.
  void was_set_up(const Answer& answer);

  /// To be sent, since the last call.
  std::vector<Answer> answers() { return std::exchange(to_send_, {}); }

  const std::optional<UnderWay>& under_way() const { return book_.under_way; }
  const std::optional<Finished>& finished() const { return book_.finished; }
  const std::vector<Rest>& rests() const { return book_.rest; }
  const std::vector<Over>& over() const { return book_.over; }
  bool is_stopping() const { return book_.under_way && (book_.under_way->stop || ends_); }
  /// Why no recording runs that should; empty: it does, or none should.
  const std::string& fault() const { return fault_; }

 private:
  void start(const Request& request, std::int64_t utc_us, const Nodes& nodes);
  void stop(const Request& request, std::int64_t utc_us);
  void mark(const Request& request, std::int64_t utc_us);
  void set_up(const Request& request, std::int64_t utc_us);
  void wait(const Request& request, const std::vector<std::int32_t>& returning, std::int64_t utc_us);
  void read_mark(const Request& request, std::int64_t utc_us);
  void note(const Mark& mark);
  void say_durable_marks(std::int32_t durable_marks, std::int64_t utc_us);
  bool answer_again(const Request& request, std::int64_t utc_us);
  bool store(DeskBook book);
  void keep(DeskBook book);
  void note_asked(const Request& request, RefusalReason reason, const std::string& what);
  void note_some(int& noted, const Request& request, RefusalReason reason, const std::string& what);
  void refuse_what_waits(const std::string& why, std::int64_t utc_us);
  void refuse(const Request& request, RefusalReason reason, std::string why, std::int64_t utc_us);
  void say(Answer answer);

  const Hands hands_;
  DeskBook book_;
  bool is_written_ = true;  // so the disk has it
  bool ends_ = false;
  bool is_empty_ = false;  // the recording under way, for certain: begun here, and no session of it ran
  bool runs_ = false;      // samples have been recorded since its latest session was begun
  std::string fault_;
  std::string store_fault_;
  int others_noted_ = 0;  // refusals, and wheels begun with, since the session was begun
  int readings_noted_ = 0;
  std::deque<Answer> known_;  // the latest, to repeat
  std::vector<Answer> to_send_;
};

/// "2026-01-31 12-00-05": what a recording is called that nobody names.
std::string name_by_time(std::int64_t utc_us);

}  // namespace roadbalance
