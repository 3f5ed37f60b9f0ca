#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "common/bus/operation.hpp"
#include "host/recorder/control/known_answers.hpp"
#include "host/recorder/control/session_state.hpp"
#include "host/recorder/recorder.hpp"

namespace roadbalance {

/// The nodes of a recording that is asked for.
struct ChosenNodes {
  std::vector<std::int32_t> nodes{};    ///< that the start names; empty: every one
  std::vector<ExpectedNode> missing{};  ///< of these, or of those of the vehicle file: not there
  bool is_any_there = true;
};

/// Obeys and answers requests; a pure state machine.  One recording at a time.
///
/// A start is done when the first samples are on the disk, a mark when it is, a stop when all is and the
/// receipts are out.
///
/// A request is in the session state, on the disk, before it is obeyed, and acts once, however often it comes
/// and whenever the recorder is killed: a start that was obeyed is answered as done by the recorder that
/// comes after, a stop goes on, a mark is noted again under the same number, a set-up is undone unless it was
/// done.
///
/// While the disk of the session state fails, marks wait in the callbacks, unless the record is in its
/// fallback folder; a stop does not wait.  The state is written again each second.  A recorder that is killed
/// before leaves the older one: a start that was refused because of the disk may then be found obeyed, a stop
/// is done again, a set-up undone.  A start that came to nothing leaves a folder without segments: its name
/// is free, and a stop or marks asked meanwhile are refused.
///
/// Requests and refusals are notes in the recording that is under way.
class SessionController {
 public:
  /// The actions that it leads.
  struct Callbacks {
    std::function<void(const SessionState&)> store;  ///< @throws std::system_error
    /// The name of what a recording of this name would collide with, which is not the remains of a start that
    /// came to nothing; empty: nothing. @throws std::system_error
    std::function<std::string(const std::string& name)> taken_by;
    std::function<void(const ActiveRecording&)> begin;  ///< lets a recorder run on its folder
    std::function<void(const std::string& by)> stop;    ///< lets it come to its end
    /// @param nodes  of a request to start  @throws ConfigError naming one that there is not
    std::function<ChosenNodes(const std::string& nodes)> choose;
    std::function<void(NoteToRecord)> note;        ///< into the recording that runs; a mark when is_written()
    std::function<Answer(const Request&)> set_up;  ///< other operations; none is done yet
    std::function<AskedSetUp()> asked_set_up;      ///< the one that set_up() has just put under way ...
    std::function<void()> forget_set_up;           ///< ... and is not to do
    std::function<bool()> is_set_up_under_way;     ///< one of them has not come to its end
    std::function<Answer(const Request&)> read_mark;  ///< Operation::kReading
  };
  SessionController(Callbacks callbacks, SessionState state);

  struct Nodes {
    int there = 0;                          ///< could be recorded and set up
    std::vector<std::int32_t> returning{};  ///< have just left, with a recording or by themselves
  };
  /// A request that needs nodes which are about to return is answered as under way and not remembered: it is
  /// repeated until there is a last word.  A set-up needs all of them; a start waits for those that are
  /// returning, and needs one: without another it is partial, and reported as such.  While nodes are being
  /// set up nothing starts.
  void take(const Request& request, std::int64_t utc_us, const Nodes& nodes);
  /// Begins a recording without a request, unless one is under way.
  /// @throws ConfigError if the name is taken; std::system_error
  void begin(const std::string& name, std::int64_t utc_us);
  /// The program ends: so does a recording.
  void end();

  /// The recorder runs.
  /// @param has_samples    samples of a node are on the disk
  /// @param durable_marks  so are marks through this number
  void runs(bool has_samples, std::int32_t durable_marks, std::int64_t utc_us);
  /// Who has not measured all the time so far: kept, for a recorder that comes after.
  void are_absent(std::vector<Absence> absence);
  /// The wall clock was set; a sleep of the computer is not meant.
  void clock_was_set(std::int64_t change_us);
  /// Marks alone are on the disk, at the end of a session.
  void marks_are_durable(std::int32_t through);
  /// It has come to its end as asked, with these receipts; nodes that were cut off hold the rest of it.
  /// @return rests of recordings before that are not fetched any more, for the session state has no room: to
  /// be declared
  /// @param last_incarnation  of its recorders
  std::vector<PendingEpoch> ended(std::vector<Receipt> receipts, std::vector<PendingEpoch> pending,
                                  std::int64_t utc_us, std::int64_t last_incarnation);
  /// Nodes hold these, too, of a recording that is over, which was not known so far.  Those for which the
  /// session state has no room are to be given again.
  void owe(const std::vector<PendingEpoch>& pending);
  /// Nothing of these is to be fetched any more.
  /// @param complete  the receipts of their recording as they are now, made of those before
  void settled(const std::vector<PendingEpoch>& pending,
               const std::function<std::vector<Receipt>(const std::vector<Receipt>&)>& complete);
  /// It has ended with an error and is to be begun again; one that has never run is given up.
  void failed(const std::string& why, bool has_run, std::int64_t utc_us);
  /// Begins it again.
  void again();
  /// Writes again a state that the disk has refused: to be called about once a second.  Until then a recorder
  /// that is killed leaves an older session state.
  void write_again();
  /// So the disk has it.
  bool is_written() const { return is_written_; }
  /// The last word on a request that was passed to Callbacks::set_up.
  void was_set_up(const Answer& answer);

  /// To be sent, since the last call.
  std::vector<Answer> answers() { return answers_.take(); }

  const std::optional<ActiveRecording>& active() const { return state_.active; }
  const std::optional<Finished>& finished() const { return state_.finished; }
  const std::vector<PendingEpoch>& pending() const { return state_.pending; }
  const std::vector<PastRecording>& past() const { return state_.past; }
  bool is_stopping() const { return state_.active && (state_.active->stop || ends_); }
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
  std::string stopped_by() const;
  bool answer_again(const Request& request, std::int64_t utc_us);
  bool store(SessionState state);
  void keep(SessionState state);
  void note_asked(const Request& request, RefusalReason reason, const std::string& what);
  void note_some(int& noted, const Request& request, RefusalReason reason, const std::string& what);
  void refuse(const Request& request, RefusalReason reason, std::string why, std::int64_t utc_us);

  const Callbacks callbacks_;
  SessionState state_;
  bool is_written_ = true;  // so the disk has it
  bool ends_ = false;
  bool is_empty_ = false;    // the recording under way, for certain: begun here, and no session of it ran
  bool began_here_ = false;  // the recording under way, by this program: by the clock that may be set since
  bool runs_ = false;        // samples have been recorded since its latest session was begun
  std::string fault_;
  std::string store_fault_;
  int others_noted_ = 0;  // refusals, and wheels begun with, since the session was begun
  int readings_noted_ = 0;
  KnownAnswers answers_;
};

/// "2026-01-31 12-00-05": the name of a recording that was started without one.
std::string name_by_time(std::int64_t utc_us);

}  // namespace roadbalance
