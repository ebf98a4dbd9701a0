# frozen_string_literal: true

require "tmpdir"

# A real server for tests. BAUDBOT names the program.
module TestServer
  # Serves the scenario wander while the block runs, which gets the address.
  def self.start(*options)
    Dir.mktmpdir do |folder|
      port_file = "#{folder}/port"
      log = "#{folder}/log"
      server = spawn(ENV.fetch("BAUDBOT", "baudbot"), "serve", "wander", "--listen", "127.0.0.1:0", "--port-file", port_file,
                     "--viewer", "off", *options, %i[out err] => log)
      begin
        deadline = Time.now + 30
        until File.exist?(port_file)
          ended = Process.wait(server, Process::WNOHANG)
          raise "the server ended, or was not ready after 30 s; it says:\n#{File.read(log)}" if ended || Time.now > deadline

          sleep 0.02
        end
        yield File.read(port_file).strip
      ensure
        unless ended
          Process.kill(:KILL, server)
          Process.wait(server)
        end
      end
    end
  end
end
