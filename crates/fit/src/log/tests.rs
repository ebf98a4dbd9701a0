use super::{Log, LogError, Options, Quantity, read};

fn log(text: &str) -> Result<Log, LogError> {
    read("log.csv", text.as_bytes(), &Options::default(), &mut |_| ())
}

fn refused(text: &str) -> String {
    log(text).unwrap_err().to_string()
}

#[test]
fn a_log_is_read_in_si_units_with_notes_and_labels() {
    let text = "\u{feff}# experiment: curve\r\n# Baud: 9600\r\ndistance_mm,\"value_raw\",sensor\r\n10,\"900\",a\r\n# note\r\n20, 300 ,b\r\n\r\n";
    let log = log(text).unwrap();
    assert_eq!(log.column(Quantity::Distance).unwrap().values, [0.01, 0.02]);
    assert_eq!(log.column(Quantity::Value).unwrap().values, [900.0, 300.0]);
    assert_eq!(log.labels.as_ref().unwrap().words, ["a", "b"]);
    assert_eq!(log.lines, [4, 6]);
    assert_eq!(log.note("baud").unwrap(), Some(9600.0));
    assert!(log.note("experiment").unwrap_err().to_string().starts_with("log.csv:1: the line"));
    assert_eq!(log.segments, vec![0..2]);
}

#[test]
fn semicolons_and_tabs_separate_as_well() {
    for text in ["time_s;x_m\n0;1\n1;2\n", "time_s\tx_m\n0\t1\n1\t2\n"] {
        assert_eq!(log(text).unwrap().column(Quantity::X).unwrap().values, [1.0, 2.0]);
    }
}

#[test]
fn what_cannot_be_used_is_named_by_file_line_and_column() {
    let cases = [
        ("", "log.csv: is empty; a log begins"),
        ("# only: this\n", "log.csv: is empty"),
        ("time_s,x_m\n", "log.csv: has column names, but no rows"),
        ("time_s,x_m\n1,2\n2\n", "log.csv:3: has 1 cells, and the line of names has 2"),
        ("time_s,x_m\n1,0,2,0\n", "decimal commas"),
        ("time_s;x_m\n1;2,5\n", "log.csv:2:2 (x_m): `2,5` has a decimal comma; write decimal points"),
        ("time_s,x_m\n1,NaN\n", "log.csv:2:2 (x_m): `NaN` is not finite"),
        ("time_s,x_m\n1,-inf\n", "log.csv:2:2 (x_m): `-inf` is not finite"),
        ("time_s,x_m\n1,left\n", "log.csv:2:2 (x_m): `left` is not a number"),
        (
            "time,x_m\n1,2\n",
            "log.csv:1:1 (time): names no unit; write `time_s`, `time_ms`, `time_us` or `time_ns`",
        ),
        (
            "time_s,x_inch\n1,2\n",
            "log.csv:1:2 (x_inch): `inch` is not a known unit; write `x_m`, `x_cm` or `x_mm`",
        ),
        ("time_s,time_ms\n1,2\n", "log.csv:1:2 (time_ms): is the second column of this meaning; column 1"),
        ("time_s,\n1,2\n", "log.csv:1:2: the column has no name"),
        ("time_s,x_m\n1,2\n,3\n", "log.csv:3:1 (time_s): has no time"),
        ("time_s,x_m\n1,2\n0.5,3\n", "log.csv:3:1 (time_s): the clock goes back by 0.5 s from line 2"),
        ("time_s,x_m\n1,2\n1,3\n", "log.csv:3:1 (time_s): has the time of line 2, but other numbers"),
        (
            "# baud: fast\ntime_s,x_m\n1,2\n",
            "log.csv:1: the line `# baud: fast` must have a number of 0 or more as its value",
        ),
        ("time_s,x_m\n1,\"2\n", "log.csv:2: the quotation mark is not closed"),
        ("time_s,x_m\n1,\u{0}\n", "log.csv:2: is not text: byte 0x00"),
        ("t_s,robot,x_m\n1,a,2\n1,b,2\n", "rows of several robots (a, b)"),
    ];
    for (text, expected) in cases {
        let error = refused(text);
        assert!(error.contains(expected), "{text:?}: {error}");
    }
}

#[test]
fn bytes_that_are_no_text_and_endless_lines_are_refused() {
    let read =
        |bytes: &[u8]| read("log.csv", bytes, &Options::default(), &mut |_| ()).unwrap_err().to_string();
    assert!(read(b"\x89MCAP0\r\n").contains("log.csv:1: is not text: byte 0x89"));
    assert!(read(b"time_s,x_m\n1,\xff\n").contains("log.csv:2: is not text: byte 0xff"));
    assert!(read(&vec![b'1'; 3 << 20]).contains("longer than 1048576 bytes"));
}

#[test]
fn a_gap_splits_the_log_and_copies_are_left_out() {
    let rows: String = (0..20).map(|i| format!("{},{i}\n", if i < 10 { i } else { i + 90 })).collect();
    let log =
        log(&format!("time_ms,x_mm,colour\n{rows}").replace(",3\n", ",3\n3,3\n").replace(",colour", ""))
            .unwrap();
    assert_eq!(log.segments, vec![0..10, 10..20]);
    let told: Vec<_> = log.warnings.iter().map(ToString::to_string).collect();
    assert_eq!(told.len(), 2, "{told:?}");
    assert!(told[0].starts_with("line 6: 1 rows are copies"), "{told:?}");
    assert!(told[1].starts_with("line 13: a gap of 0.091000 s"), "{told:?}");
}

#[test]
fn columns_may_have_other_names_and_those_not_understood_are_told() {
    let options = Options {
        renamed: vec![("time_s".into(), "stamp".into()), ("compass".into(), "mag".into())],
        readings: vec!["compass".into()],
        robot: Some("b".into()),
    };
    let text = "stamp,robot,mag,colour\n1,a,2,red\n1,b,3,blue\n2,b,4,red\n";
    let log = read("log.csv", text.as_bytes(), &options, &mut |_| ()).unwrap();
    assert_eq!(log.reading("compass").unwrap().values, [3.0, 4.0]);
    assert_eq!(log.warnings[0].to_string(), "columns not understood, and not used: colour");
    for (text, expected) in [
        ("time_s,mag\n1,2\n", "no column `stamp`; it has: time_s, mag"),
        ("stamp,mag,robot\n1,2,a\n", "no rows of the robot `b`; it has: a"),
    ] {
        let error = read("log.csv", text.as_bytes(), &options, &mut |_| ()).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}");
    }
    let options = Options { renamed: vec![("tiem_s".into(), "t".into())], ..Options::default() };
    let error = read("log.csv", "t,x_m\n1,2\n".as_bytes(), &options, &mut |_| ()).unwrap_err().to_string();
    assert!(error.starts_with(
        "log.csv:1:1 (t): `tiem_s` is not a name that a column can have here; known are: time_s"
    ));
}

#[test]
fn rows_of_one_instant_that_complement_each_other_are_one() {
    let log = log("time_s,command_left,x_m\n0,1,\n0,,5\n1,,6\n2,2,\n2,,7\n2,,7\n").unwrap();
    let column = |quantity| log.column(quantity).unwrap().values.clone();
    assert_eq!(column(Quantity::Time), [0.0, 1.0, 2.0]);
    assert_eq!(column(Quantity::X), [5.0, 6.0, 7.0]);
    let commands = column(Quantity::CommandLeft);
    assert_eq!((commands[0], commands[1].is_nan(), commands[2]), (1.0, true, 2.0));
    assert_eq!(log.lines, [3, 4, 7]);
    assert!(refused("time_s,command_left,x_m\n0,1,4\n0,,5\n").contains("has the time of line 2"));
}

#[test]
fn a_log_without_a_line_of_names_is_recognised() {
    let numbers = "log.csv:1: the first line has no names, but numbers; put a line of column names before it";
    for text in [
        "5300,7211\n5400,7300\n",
        "ir_0,20,915\nir_0,30,800\n",
        "0,5;1,5\n",
        "0.1 20 915\n",
        "2026-01-01,20,915\n",
        "20\n",
    ] {
        assert!(refused(text).starts_with(numbers), "{text}: {}", refused(text));
    }
    let many = (0..400).map(|i| format!("beam{i}")).collect::<Vec<_>>().join(",");
    let unknown = refused(&format!("{many}\n"));
    assert!(
        unknown.contains("the first line has no name that is understood: beam0, beam1")
            && unknown.len() < 500,
        "{unknown}"
    );
    assert!(refused("time value\n1 2\n").contains("with commas, semicolons or tabs between them"));
    // One that is understood is enough: lasers have a column a ray.
    assert_eq!(log("time_s,0,1\n1,2,3\n").unwrap().len(), 1);
}

#[test]
fn a_log_of_carmen_is_recognised() {
    for line in [
        "PARAM laser_front_laser_resolution 0.5 0 nohost 0",
        "ODOM 0.1 0.2 0.3 0.4 0.5 0.6 0.7 nohost 0.8",
        "FLASER 2 1.0 2.0 0.1 0.2 0.3 0.1 0.2 0.3 0.7 nohost 0.8",
    ] {
        let told = refused(&format!("# message_name [message contents]\n{line}\n"));
        assert!(
            told.starts_with(
                "log.csv:2: is a log of CARMEN, and no table; make one of its lines: FLASER has"
            ),
            "{told}"
        );
    }
}

#[test]
fn a_warning_does_not_list_hundreds_of_columns() {
    let names = (0..400).map(|i| format!("beam{i}")).collect::<Vec<_>>().join(",");
    let log = log(&format!("time_s,{names}\n1{}\n", ",2".repeat(400))).unwrap();
    let warning = log.warnings[0].to_string();
    assert!(warning.ends_with("beam11 and 388 more") && warning.len() < 200, "{warning}");
}

#[test]
fn a_sensor_that_is_called_sensor_has_its_readings() {
    let options = Options { readings: vec!["sensor".into()], ..Options::default() };
    let log = read("log.csv", "heading_rad,sensor\n1,2\n2,3\n".as_bytes(), &options, &mut |_| ()).unwrap();
    assert_eq!(log.reading("sensor").unwrap().values, [2.0, 3.0]);
}
