import java.io.DataInputStream;
import java.io.ByteArrayInputStream;
import java.io.PrintWriter;
import java.lang.reflect.Constructor;
import java.util.Arrays;
import java.util.HashMap;
import java.util.Map;
import lcm.lcm.LCMDataOutputStream;
import lcm.lcm.LCMEncodable;
import lcm.logging.Log;

/**
 * Decodes every event of a segment by its type's fingerprint with the classes that lcm-spy uses, and prints its type
 * and whether encoding it again gives the same bytes.  Arguments: segment, output, names of types.
 */
public class DecodeEvents {
  public static void main(String[] args) throws Exception {
    Map<Long, Constructor<?>> types = new HashMap<>();
    for (String name : Arrays.copyOfRange(args, 2, args.length)) {
      Class<?> type = Class.forName("wire." + name);
      types.put(type.getField("LCM_FINGERPRINT").getLong(null), type.getConstructor(byte[].class));
    }
    Log log = new Log(args[0], "r");
    try (PrintWriter out = new PrintWriter(args[1])) {
      while (true) {
        byte[] data = log.readNext().data;
        long fingerprint = new DataInputStream(new ByteArrayInputStream(data)).readLong();
        Constructor<?> type = types.get(fingerprint);
        if (type == null) {
          out.print("unknown\n");
          continue;
        }
        LCMEncodable message = (LCMEncodable) type.newInstance((Object) data);
        LCMDataOutputStream again = new LCMDataOutputStream();
        message.encode(again);
        out.print(type.getDeclaringClass().getSimpleName() + " " + Arrays.equals(again.toByteArray(), data) + "\n");
      }
    } catch (java.io.EOFException end) {
      // the log is over
    }
  }
}
