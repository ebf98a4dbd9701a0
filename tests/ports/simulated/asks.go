// Asks a Khepera for its sensors in Go: goroutines, and termios by system calls. Prints as asks.c. Argument: the port.
package main

import (
	"fmt"
	"os"
	"syscall"
	"time"
	"unsafe"
)

func main() {
	file, err := syscall.Open(os.Args[len(os.Args)-1], syscall.O_RDWR|syscall.O_NOCTTY, 0)
	if err != nil {
		panic(err)
	}
	port := syscall.Termios{Cflag: syscall.B9600 | syscall.CS8 | syscall.CREAD | syscall.CLOCAL | syscall.CSTOPB}
	port.Cc[syscall.VMIN] = 1
	if _, _, failed := syscall.Syscall(syscall.SYS_IOCTL, uintptr(file), syscall.TCSETS, uintptr(unsafe.Pointer(&port))); failed != 0 {
		panic(failed)
	}
	bytes := make(chan byte)
	go func() {
		one := make([]byte, 1)
		for {
			if n, _ := syscall.Read(file, one); n != 1 {
				close(bytes)
				return
			}
			bytes <- one[0]
		}
	}()
	for asked := 0; asked < 5; asked++ {
		begun, answered := time.Now(), 0
		if n, _ := syscall.Write(file, []byte("N\r")); n != 2 {
			panic(n)
		}
		for last := byte(0); last != '\n'; answered++ {
			last = <-bytes
		}
		fmt.Println(answered, time.Since(begun).Nanoseconds())
		time.Sleep(20 * time.Millisecond)
	}
}
