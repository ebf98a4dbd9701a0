package main

import (
	"fmt"
	"os"
	"strconv"
	"strings"
)

// env gives a variable of the environment; an empty one counts as unset.
func env(name, unset string) string {
	if value := os.Getenv(name); value != "" {
		return value
	}
	return unset
}

// findAddress gives HOST:PORT or unix:/PATH of the server.
func findAddress() (string, error) {
	address := env("BAUDBOT_CONNECT", "127.0.0.1:7400")
	if strings.HasPrefix(address, "https://") {
		return "", fmt.Errorf("BAUDBOT_CONNECT=%s: this example has no TLS; give HOST:PORT or unix:/PATH of a server without TLS", address)
	}
	return strings.TrimSuffix(strings.TrimPrefix(address, "http://"), "/"), nil
}

// findReconnectS gives for how long to try again after a lost connection, in seconds.
func findReconnectS() (float64, error) {
	text := env("BAUDBOT_RECONNECT_S", "600")
	seconds, err := strconv.ParseFloat(text, 64)
	if err != nil {
		return 0, fmt.Errorf("BAUDBOT_RECONNECT_S must be a number of seconds, is %q", text)
	}
	return seconds, nil
}

// findToken gives the token of the environment, else that of the user's own server on this machine (docs/reference/trust.md
// of baudbot), else "". A server that was started again has a new one.
func findToken(address string) (string, error) {
	if token := os.Getenv("BAUDBOT_TOKEN"); token != "" {
		return strings.TrimSpace(token), nil
	}
	if file := os.Getenv("BAUDBOT_TOKEN_FILE"); file != "" {
		token, err := os.ReadFile(file)
		if err != nil {
			return "", fmt.Errorf("BAUDBOT_TOKEN_FILE: %w", err)
		}
		return strings.TrimSpace(string(token)), nil
	}
	name := strings.Replace(address, "localhost:", "127.0.0.1:", 1) + ".token"
	common := fmt.Sprintf("/tmp/baudbot-%d", os.Getuid())
	for _, folder := range []string{os.Getenv("XDG_RUNTIME_DIR") + "/baudbot", common, os.Getenv("HOME") + "/.baudbot"} {
		if token, err := os.ReadFile(folder + "/" + name); err == nil {
			return strings.TrimSpace(string(token)), nil
		}
	}
	return "", nil
}
