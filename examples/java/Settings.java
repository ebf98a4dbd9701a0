import baudbot.v1.AttachRequest;
import baudbot.v1.Hello;
import baudbot.v1.PortMode;
import com.sun.security.auth.module.UnixSystem;
import java.io.IOException;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.List;
import java.util.Map;

/** What the environment says about the server. Keep this file, and replace Follow.java. */
record Settings(Map<String, String> environment) {
    /** A variable; an empty one counts as unset. */
    private String find(String name, String unset) {
        String value = environment.getOrDefault(name, "");
        return value.isEmpty() ? unset : value;
    }

    /** HOST:PORT or unix:/PATH of the server. */
    String address() throws Link.Failure {
        String given = find("BAUDBOT_CONNECT", "127.0.0.1:7400");
        if (given.startsWith("https://")) {
            throw new Link.Failure("BAUDBOT_CONNECT=" + given
                    + ": this example has no TLS; give HOST:PORT or unix:/PATH of a server without TLS");
        }
        return given.replaceFirst("^http://", "").replaceFirst("/$", "");
    }

    /** For how long to try again after a lost connection. */
    double reconnectS() throws Link.Failure {
        String text = find("BAUDBOT_RECONNECT_S", "600");
        try {
            return Double.parseDouble(text);
        } catch (NumberFormatException error) {
            throw new Link.Failure("BAUDBOT_RECONNECT_S must be a number of seconds, is " + text);
        }
    }

    /** What the server is told first: who drives what. */
    AttachRequest hello(String brain) {
        var hello = Hello.newBuilder()
                .setWorld(find("BAUDBOT_WORLD", "wander"))
                .addAllRobots(List.of(find("BAUDBOT_ROBOT", "robot").split(",")))
                .setMode(PortMode.PORT_MODE_MESSAGES)
                .setBrain(brain)
                .setThinksAsScenario(true);
        return AttachRequest.newBuilder().setHello(hello).build();
    }

    /** BAUDBOT_TOKEN, else the one in BAUDBOT_TOKEN_FILE, else that of the user's own server, else nothing. */
    String token() throws Link.Failure {
        String token = find("BAUDBOT_TOKEN", ""), file = find("BAUDBOT_TOKEN_FILE", "");
        if (!token.isEmpty()) {
            return token.strip();
        }
        try {
            return file.isEmpty() ? ownToken() : Files.readString(Path.of(file)).strip();
        } catch (IOException error) {
            throw new Link.Failure("the token cannot be read: " + error);
        }
    }

    /** A server on this machine has its token in one of three places (docs/reference/trust.md of baudbot). */
    private String ownToken() throws Link.Failure, IOException {
        String user = String.valueOf(new UnixSystem().getUid());
        String name = address().replace("localhost:", "127.0.0.1:") + ".token";
        for (Path folder : List.of(
                Path.of(find("XDG_RUNTIME_DIR", "/run/user/" + user), "baudbot"),
                Path.of("/tmp/baudbot-" + user),
                Path.of(System.getProperty("user.home"), ".baudbot"))) {
            if (Files.isReadable(folder.resolve(name))) {
                return Files.readString(folder.resolve(name)).strip();
            }
        }
        return "";
    }
}
