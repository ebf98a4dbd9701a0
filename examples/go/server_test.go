package main

import (
	"os"
	"os/exec"
	"path/filepath"
	"strings"
	"testing"
	"time"
)

// startServer serves the scenario wander until the test is over, and gives its address.
func startServer(t *testing.T, options ...string) string {
	folder := t.TempDir()
	portFile, log := filepath.Join(folder, "port"), filepath.Join(folder, "log")
	arguments := []string{"serve", "wander", "--listen", "127.0.0.1:0", "--port-file", portFile, "--viewer", "off"}
	server := exec.Command(env("BAUDBOT", "baudbot"), append(arguments, options...)...)
	output, err := os.Create(log)
	if err != nil {
		t.Fatal(err)
	}
	defer output.Close()
	server.Stdout, server.Stderr = output, output
	if err := server.Start(); err != nil {
		t.Fatalf("the server cannot be started (BAUDBOT names its program): %v", err)
	}
	ended := make(chan error, 1)
	go func() { ended <- server.Wait() }()
	t.Cleanup(func() { _ = server.Process.Kill() })
	for deadline := time.Now().Add(30 * time.Second); time.Now().Before(deadline) && len(ended) == 0; time.Sleep(20 * time.Millisecond) {
		if address, err := os.ReadFile(portFile); err == nil {
			return strings.TrimSpace(string(address))
		}
	}
	text, _ := os.ReadFile(log)
	t.Fatalf("the server ended, or was not ready after 30 s; it says:\n%s", text)
	return ""
}
