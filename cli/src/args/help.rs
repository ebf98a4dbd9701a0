//! The text of `baudbot help COMMAND` besides the options.

pub(super) const PACE_HELP: &str = "\
When a tick ends:
  lockstep   when every brain has answered: the same run on any machine
  real-time  by the wall clock, without waiting for brains
  scaled:X   by the wall clock, X simulated seconds per second, without waiting for brains
  free       immediately, without waiting for brains";

pub(super) const SERVED_PACE_HELP: &str = "\
When a tick ends; the default is real-time, and with --resume the recorded pace:
  lockstep   when every brain has answered: the same run on any machine
  real-time  by the wall clock, without waiting for brains
  scaled:X   by the wall clock, X simulated seconds per second, without waiting for brains
  free       immediately, without waiting for brains";

pub(super) const RUN_EXAMPLES: &str = "\
Examples:
  baudbot run                                    the default: wander, brain avoid, 60 s
  baudbot run wander --pace real-time --seconds 10
  baudbot run khepera --set robots.khepera.link.baud=9600
  baudbot run --seconds 2 --timeline run.pftrace   a trace for ui.perfetto.dev
  baudbot run --record run.mcap                  for a replay: see `baudbot help replay`
  baudbot run firmware --gdb robot=1234          waits for avr-gdb: see docs/how-to/debugging.md
  baudbot run --over grpc                        the same run through a server in this process
  baudbot run my.toml --brain alice=avoid --brain none --seed 7 --csv run.csv
  baudbot run wander --json --quiet | python3 -m json.tool

Ctrl-C (or SIGTERM, or SIGHUP) ends a run early: the summary is still printed, and the exit code is 130. A second Ctrl-C
ends the program at once, without a summary. The exit code is 1 if a recording could not be completed.

With --listen or --viewer a run is also a server, with the options about access and limits of `baudbot help serve`.";

pub(super) const SWEEP_EXAMPLES: &str = "\
Examples:
  baudbot sweep baud-vs-speed
  baudbot sweep my.toml --out /tmp/my --jobs 2
  baudbot sweep my.toml --seeds 101..120 --out my-101.sweep    the same with other seeds
  baudbot sweep my.toml --find baud              the lowest sufficient baud rate
  baudbot sweep my.toml --connect 127.0.0.1:7400
  baudbot sweep my.toml --shard 0/8              the first of eight shards; the last is 7/8
  baudbot sweep my.toml --merge my.shards        the outputs, from the journals of all shards

The folder DIR gets rows.jsonl (a line as each run ends), and at the end rows.csv, rows.parquet, summary.txt and
the charts. If a sweep was stopped, by Ctrl-C (exit code 130), a full disk or a power cut, the same command resumes it.
The exit code is 1 if some of the runs failed.";

pub(super) const TUNE_EXAMPLES: &str = "\
Examples:
  baudbot tune tune-sweeper
  baudbot tune my.toml --out /tmp/my --jobs 2
  baudbot tune my.toml --seeds 101..105 --out my-101.tune      the same with other seeds

The experiment file has a table [tune], which defines the score to maximize, and a range for each of its fields. The
folder DIR gets rows.jsonl (one line per run), and at the end candidates.csv, trace.svg, summary.txt and, if the brain
is described in TOML, best.toml, for --brain. If a tuning run was stopped, the same command resumes it; a finished one
continues if the file asks for more generations.";

pub(super) const WORST_EXAMPLES: &str = "\
Examples:
  baudbot worst worst-wander                    1000 runs, the ten worst, and the plainest scenario that still fails
  baudbot worst my.toml --within 5m             as many runs as five minutes allow
  baudbot worst my.toml --runs 4000 --first     at most 4000, and none after the first that fails; exit code 1 if one does

The experiment file may have a table [require], which states what must hold; without it, the robot must not run into anything. Each
of its fields has a range or values, of which the search looks for those in which the robot fails. The folder DIR gets rows.jsonl (one
line per run), summary.txt, and of the worst run worst.toml (a scenario), worst.mcap (its recording) and worst.svg (its timing at the
instant that decides). Exit code: 0 if all runs keep to what is required, 1 if one does not. If it was stopped, the same command resumes
it, and continues with a larger --runs.";

pub(super) const SERVE_EXAMPLES: &str = "\
Examples:
  baudbot serve                                  wander at 127.0.0.1:7400, in real time
  baudbot serve wander khepera --pace lockstep
  baudbot serve my.toml --listen unix:/tmp/baudbot.sock --listen 127.0.0.1:0
  baudbot serve my.toml --record run.mcap        if it is killed: baudbot serve --resume run.mcap
  baudbot serve --recordings runs                record and replay in the viewer, or over gRPC
  baudbot serve --trainer unix:/tmp/t.sock       for a program that learns: it creates its worlds itself
  baudbot serve devices/khepera-ascii --port khepera=pty:khepera.tty
                                                 a serial port for programs not written for baudbot";

pub(super) const REPLAY_EXAMPLES: &str = "\
Examples:
  baudbot run wander --record run.mcap
  baudbot replay run.mcap                        identical, or the first tick and field that differ
  baudbot replay run.mcap --view                 in a browser, forwards and backwards
  baudbot replay run.mcap --to 12.5 --fork       live from there, for new brains
  baudbot serve --resume run.mcap                live from its end: after a crash, for example

Exit codes:
  0    identical, and nothing is missing
  1    the replay differs, or an error occurred
  2    the file or the options cannot be used
  3    incomplete: identical wherever a comparison was possible; the message states how much was compared
  130  stopped by Ctrl-C

A recording contains all inputs of the world, so any machine can simulate the run again. Of a damaged file, the part that
can be replayed is compared. docs/reference/recording.md describes the file, and other programs that read it.";

pub(super) const BRAIN_EXAMPLES: &str = "\
Examples:
  baudbot brain --list
  baudbot brain avoid                            drives the only robot of the only world at 127.0.0.1:7400
  baudbot brain avoid --connect unix:/tmp/baudbot.sock --world wander --robot robot
  baudbot brain avoid --reconnect off            exits when the server does";

pub(super) const CHECK_EXAMPLES: &str = "\
Examples:
  baudbot check wander
  baudbot check my.toml --set robots.alice.link.baud=4800
  baudbot check khepera --svg khepera.svg        a picture of the arena";

pub(super) const DIAGRAM_EXAMPLES: &str = "\
Examples:
  baudbot diagram wander                         a table of the events around the third control cycle
  baudbot diagram wander --svg timing.svg        the same as a picture
  baudbot diagram khepera --cycle 5 --svg -      one control cycle, with the time beyond Δt in red
  baudbot diagram my.toml --robot alice --brain avoid --at 12.5 --span 100
  baudbot diagram run.mcap --at 12.5             the same for a recorded run
  baudbot diagram firmware --pins D9,A0 --svg -  the signals on the pins of a chip with your own program";

pub(super) const BUDGET_EXAMPLES: &str = "\
Examples:
  baudbot budget wander
  baudbot budget wander --set robots.robot.link.baud=38400 --check
  baudbot budget my.toml --robot alice --json
  baudbot budget wander --svg budget.svg         the timing diagram of a typical cycle
  baudbot budget wander --measured run.mcap      with thinking times as measured in a run
  baudbot budget rover/robot.toml --seconds 30   measures a program on a chip in a run of 30 s";

pub(super) const PRESET_EXAMPLES: &str = "\
Examples:
  baudbot preset                                 all presets, by kind
  baudbot preset khepera-1                       its file, with the source of each number
  baudbot preset gp2d12 --json
  baudbot preset khepera-1 --json | jq '.values[] | select(.standing == \"guess\")'

A scenario uses a preset with `preset = \"khepera-1\"`: the preset of a robot in [[robots]], any other in the table of its part.";

pub(super) const EVIDENCE_EXAMPLES: &str = "\
Examples:
  baudbot evidence                               all comparisons, one line each
  baudbot evidence e-puck-ir                     the points of all comparisons about a preset
  baudbot evidence khepera-ir --json
  baudbot evidence --write docs                  the page docs/evidence.md, with pictures in docs/pictures

The exit code is 1 if a point is not as expected: it disagrees and should agree, or agrees and is known to disagree.";

pub(super) const WATCH_EXAMPLES: &str = "\
Examples:
  baudbot watch                                  the only world at 127.0.0.1:7400
  baudbot watch --world wander --once
  baudbot watch --foxglove                       Foxglove then opens ws://127.0.0.1:8765";
