import java.io.IOException;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.concurrent.TimeUnit;

/** A real server for tests, run by the program that BAUDBOT names (default: baudbot). */
final class TestServer implements AutoCloseable {
    private final Path folder = Files.createTempDirectory("baudbot-");
    private final Path port = folder.resolve("port"), log = folder.resolve("log");
    private final Process process;

    /** Serves wander until the robot has driven for ten seconds. */
    TestServer() throws IOException, InterruptedException {
        String program = System.getenv().getOrDefault("BAUDBOT", "baudbot");
        process = new ProcessBuilder(program, "serve", "wander", "--listen", "127.0.0.1:0", "--port-file", port.toString(),
                "--viewer", "off", "--pace", "lockstep", "--set", "end.after_s=10.0")
                .redirectErrorStream(true).redirectOutput(log.toFile()).start();
        long startNs = System.nanoTime();
        while (!Files.exists(port)) {
            if (process.waitFor(10, TimeUnit.MILLISECONDS) || System.nanoTime() - startNs > 30e9) {
                String says = Files.readString(log);
                close();
                throw new IOException("the server has ended, or is not ready after 30 s; it says:\n" + says);
            }
        }
    }

    String address() throws IOException {
        return Files.readString(port).strip();
    }

    @Override
    public void close() throws IOException {
        process.destroy();
        process.onExit().join();
        Files.deleteIfExists(port);
        Files.deleteIfExists(log);
        Files.delete(folder);
    }
}
