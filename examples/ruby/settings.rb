# frozen_string_literal: true

module Link
  # What the environment says; an empty variable counts as unset.
  module Settings
    module_function

    def find(name, unset = nil)
      value = ENV.fetch(name, "")
      value.empty? ? unset : value
    end

    # HOST:PORT or unix:/PATH of the server.
    def address
      given = find("BAUDBOT_CONNECT", "127.0.0.1:7400")
      if given.start_with?("https://")
        raise Error, "BAUDBOT_CONNECT=#{given}: this example has no TLS; give HOST:PORT or unix:/PATH of a server without TLS"
      end

      given.delete_prefix("http://").chomp("/")
    end

    # For how long to try again after a lost connection.
    def reconnect_s
      text = find("BAUDBOT_RECONNECT_S", "600")
      Integer(text, 10, exception: false) || Float(text)
    rescue ArgumentError
      raise Error, "BAUDBOT_RECONNECT_S must be a number of seconds, is #{text.inspect}"
    end

    def hello(program)
      { world: find("BAUDBOT_WORLD", "wander"), robots: find("BAUDBOT_ROBOT", "robot").split(","),
        mode: :PORT_MODE_MESSAGES, brain: program, thinks_as_scenario: true }
    end

    def metadata(address)
      token = find("BAUDBOT_TOKEN") || token_in_file || own_token(address)
      token ? { "authorization" => "Bearer #{token.strip}" } : {}
    end

    def token_in_file
      file = find("BAUDBOT_TOKEN_FILE")
      file && File.read(file)
    rescue SystemCallError => e
      raise Error, "BAUDBOT_TOKEN_FILE: #{e.message}"
    end

    # The token of the user's own server on this machine (docs/reference/trust.md of baudbot). A server that was started again
    # has a new one.
    def own_token(address)
      folders = ["#{ENV['XDG_RUNTIME_DIR']}/baudbot", "/tmp/baudbot-#{Process.uid}", "#{ENV['HOME']}/.baudbot"]
      files = folders.map { |folder| "#{folder}/#{address.sub('localhost:', '127.0.0.1:')}.token" }
      file = files.find { |candidate| File.readable?(candidate) }
      file && File.read(file)
    end
  end
end
