import java.io.PrintWriter;
import lcm.logging.Log;
import wire.scan_block_t;

/** Prints the scan blocks of a segment, decoded by the classes that lcm-spy uses. */
public class PrintBlocks {
  public static void main(String[] args) throws Exception {
    Log log = new Log(args[0], "r");
    try (PrintWriter out = new PrintWriter(args[1])) {
      while (true) {
        Log.Event event = log.readNext();
        if (!event.channel.endsWith("_SCAN")) continue; // the recorder's own
        scan_block_t b = new scan_block_t(event.data);
        out.print(b.node + " " + b.epoch + " " + b.sequence + " " + b.first_scan + " " + b.scans + " " + b.time_ns
            + " " + b.period_ps + " " + b.counts[0][0] + " " + b.counts[19][15] + " " + b.quality + "\n");
      }
    } catch (java.io.EOFException end) {
      // the log is over
    }
  }
}
