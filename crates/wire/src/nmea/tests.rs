use std::string::String;
use std::vec;
use std::vec::Vec;

use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::Index;

use super::*;
use crate::error::NoRoom;

const FIX: Fix = Fix {
    time_utc_ms: ((6 * 60 + 49) * 60 + 51) * 1000 + 7,
    date: (26, 4, 6),
    valid: true,
    latitude_deg: 23.0 + 7.125_6 / 60.0,
    longitude_deg: -(120.0 + 16.443_8 / 60.0),
    speed_m_s: 0.5,
    course_deg: 165.476,
    altitude_m: -39.94,
    satellites: 8,
    hdop: 0.954,
    pdop_vdop: None,
};
const NO_FIX: Fix = Fix { valid: false, satellites: 2, ..FIX };

const SKY: [Satellite; 12] = {
    let mut sky = [Satellite { prn: 2, elevation_deg: 7, azimuth_deg: 5, snr_db: 30 }; 12];
    let mut index = 0;
    while index < 12 {
        sky[index].prn += 2 * index as u8;
        sky[index].elevation_deg += 6 * index as u8;
        sky[index].azimuth_deg += 29 * index as u16;
        index += 1;
    }
    sky
};

fn written(write: impl FnOnce(&mut [u8]) -> Result<usize, NoRoom>) -> String {
    let mut out = vec![0xaa; 1000];
    let len = write(&mut out).unwrap();
    assert!(out[len..].iter().all(|&byte| byte == 0xaa), "nothing is written behind the sentence");
    out.truncate(len);
    String::from_utf8(out).unwrap()
}

fn rmc(fix: &Fix) -> String {
    written(|out| write_rmc(fix, out))
}

fn gga(fix: &Fix) -> String {
    written(|out| write_gga(fix, out))
}

fn gsa(fix: &Fix, in_view: &[Satellite]) -> String {
    written(|out| write_gsa(fix, in_view, out))
}

fn gsv(in_view: &[Satellite]) -> String {
    written(|out| write_gsv(in_view, out))
}

fn parse_rmc(line: &[u8]) -> Rmc {
    let Ok(Sentence::Rmc(rmc)) = parse(line) else { panic!("{:?}", parse(line)) };
    rmc
}

fn parse_gga(line: &[u8]) -> Gga {
    let Ok(Sentence::Gga(gga)) = parse(line) else { panic!("{:?}", parse(line)) };
    gga
}

/// The fields with the frame that makes them a sentence.
fn framed(fields: &str) -> Vec<u8> {
    let sum = fields.bytes().fold(0, |sum, byte| sum ^ byte);
    std::format!("${fields}*{sum:02X}\r\n").into_bytes()
}

/// 0.5 m/s is 0.97 knots. The checksums are those of another program.
#[test]
fn sentences_of_a_fix() {
    assert_eq!(rmc(&FIX), "$GPRMC,064951.007,A,2307.1256,N,12016.4438,W,0.97,165.48,260406,,,A*7B\r\n");
    assert_eq!(gga(&FIX), "$GPGGA,064951.007,2307.1256,N,12016.4438,W,1,08,0.95,-39.9,M,,,,*36\r\n");
    assert_eq!(gsa(&FIX, &SKY), "$GPGSA,A,3,02,04,06,08,10,12,14,16,,,,,,0.95,*06\r\n");
    let in_space = Fix { pdop_vdop: Some((1.5, 1.2)), ..FIX };
    assert_eq!(gsa(&in_space, &SKY), "$GPGSA,A,3,02,04,06,08,10,12,14,16,,,,,1.50,0.95,1.20*01\r\n");
    let lost = Fix { pdop_vdop: Some((1.5, 1.2)), ..NO_FIX };
    assert_eq!(gsa(&lost, &SKY), gsa(&NO_FIX, &SKY));
    let sky = [SKY[0], SKY[1], SKY[2], SKY[11], Satellite { snr_db: 0, azimuth_deg: 360, ..SKY[3] }];
    assert_eq!(
        gsv(&sky),
        "$GPGSV,2,1,05,02,07,005,30,04,13,034,30,06,19,063,30,24,73,324,30*72\r\n\
         $GPGSV,2,2,05,08,25,000,*43\r\n"
    );
}

/// By hand: `G^P` = 0x17, `G^S` = 0x14, `V` = 0x56 make 0x55; of the commas one is left, 0x2c, and of the digits
/// `1^1^0^0` nothing. 0x55 ^ 0x2c = 0x79.
#[test]
fn an_empty_sky_is_one_sentence() {
    assert_eq!(gsv(&[]), "$GPGSV,1,1,00*79\r\n");
}

#[test]
fn without_a_fix_the_fields_of_position_and_motion_are_empty() {
    assert_eq!(rmc(&NO_FIX), "$GPRMC,064951.007,V,,,,,,,260406,,,N*43\r\n");
    assert_eq!(gga(&NO_FIX), "$GPGGA,064951.007,,,,,0,02,,,M,,,,*3F\r\n");
    assert_eq!(gsa(&NO_FIX, &SKY), "$GPGSA,A,1,,,,,,,,,,,,,,,*1E\r\n");
    let rmc = parse_rmc(rmc(&NO_FIX).as_bytes());
    assert_eq!((rmc.position, rmc.speed_m_s, rmc.course_deg), (None, None, None));
    assert_eq!((rmc.time_utc_ms, rmc.date), (Some(FIX.time_utc_ms), Some(FIX.date)));
    let gga = parse_gga(gga(&NO_FIX).as_bytes());
    assert_eq!((gga.position, gga.quality, gga.satellites), (None, 0, Some(2)));
}

/// The cable at 4800 baud has room for 480 characters a second.
#[test]
fn a_cycle_once_a_second_fits_into_4800_baud_as_a_real_one_does() {
    let cycle = [gga(&FIX), gsa(&FIX, &SKY), gsv(&SKY), rmc(&FIX)];
    assert_eq!(cycle[2].matches("$GPGSV").count(), 3);
    let len = cycle.concat().len();
    assert!((380..480).contains(&len), "{len}");
    assert_eq!(len, 401, "as docs/reference/wire.md says");
}

#[test]
fn a_sentence_of_a_real_receiver_is_read() {
    let rmc = parse_rmc(b"$GPRMC,064951.000,A,2307.1256,N,12016.4438,E,0.03,165.48,260406,3.05,W,A*2C\r\n");
    assert_eq!((rmc.time_utc_ms, rmc.date), (Some(24_591_000), Some((26, 4, 6))));
    let position = Position { latitude_deg: 23.0 + 7.1256 / 60.0, longitude_deg: 120.0 + 16.4438 / 60.0 };
    assert_eq!((rmc.position, rmc.course_deg), (Some(position), Some(165.48)));
    let speed_m_s = rmc.speed_m_s.unwrap();
    assert!((speed_m_s - 0.015_433).abs() < 1e-6, "{speed_m_s}");
    // Fewer digits, another constellation, no carriage return and line feed.
    let gga = parse_gga(framed("GNGGA,064951,2307,S,12016.5,W,2,12,1,7,M,17.8,M,,").trim_ascii_end());
    let position = Position { latitude_deg: -(23.0 + 7.0 / 60.0), longitude_deg: -(120.0 + 16.5 / 60.0) };
    assert_eq!((gga.time_utc_ms, gga.position), (Some(24_591_000), Some(position)));
    assert_eq!((gga.quality, gga.satellites), (2, Some(12)));
    assert_eq!((gga.hdop, gga.altitude_m), (Some(1.0), Some(7.0)));
    assert_eq!(parse(&framed("GPGSA,A,1")), Ok(Sentence::Other));
}

proptest! {
    #[test]
    fn a_fix_arrives_as_near_as_its_fields_can_say(fix in fix()) {
        let half_unit_deg = 0.5001 / 600_000.0;
        let near = |position: Option<Position>| position.is_some_and(|position| {
            (position.latitude_deg - fix.latitude_deg).abs() <= half_unit_deg
                && (position.longitude_deg - fix.longitude_deg).abs() <= half_unit_deg
        });
        let rmc = parse_rmc(rmc(&fix).as_bytes());
        prop_assert!(near(rmc.position), "{rmc:?}");
        prop_assert_eq!((rmc.time_utc_ms, rmc.date), (Some(fix.time_utc_ms), Some(fix.date)));
        let speed_m_s = rmc.speed_m_s.unwrap();
        prop_assert!((speed_m_s - fix.speed_m_s).abs() <= 0.002_573, "{speed_m_s}");
        let turn_deg = (rmc.course_deg.unwrap() - fix.course_deg).rem_euclid(360.0);
        prop_assert!(turn_deg.min(360.0 - turn_deg) <= 0.005_001, "{turn_deg}");
        let gga = parse_gga(gga(&fix).as_bytes());
        prop_assert!(near(gga.position), "{gga:?}");
        prop_assert_eq!((gga.time_utc_ms, gga.quality), (Some(fix.time_utc_ms), 1));
        prop_assert_eq!(gga.satellites, Some(fix.satellites));
        prop_assert!((gga.hdop.unwrap() - fix.hdop).abs() <= 0.005_001);
        prop_assert!((gga.altitude_m.unwrap() - fix.altitude_m).abs() <= 0.050_001);
    }

    #[test]
    fn any_fix_gives_sound_sentences(fix in any_fix(), sky in sky()) {
        let sentences = rmc(&fix) + &gga(&fix) + &gsa(&fix, &sky) + &gsv(&sky);
        let mut read = 0;
        for line in sentences.split_inclusive('\n') {
            prop_assert!(line.is_ascii() && line.len() <= MAX_SENTENCE, "{line}");
            prop_assert!(parse(line.as_bytes()).is_ok(), "{line}");
            read += 1;
        }
        prop_assert_eq!(read, 3 + sky.len().min(36).div_ceil(4).max(1));
    }

    #[test]
    fn one_altered_byte_is_always_found(fix in any_fix(), sky in sky(), at: Index, altered: u8) {
        for text in [rmc(&fix), gga(&fix), gsa(&fix, &sky)] {
            let mut line = text.into_bytes();
            let at = at.index(line.len());
            if line[at] != altered {
                line[at] = altered;
                prop_assert!(parse(&line).is_err(), "{}", line.escape_ascii());
            }
        }
    }

    #[test]
    fn any_bytes_do_no_harm(bytes in vec(any::<u8>(), 0..100)) {
        let _ = parse(&bytes);
    }

    /// Behind a sound checksum, where random bytes hardly come.
    #[test]
    fn any_fields_do_no_harm(
        name in "GP(RMC|GGA|GSA)|[A-Z]{0,6}", fields in vec("|[AVNSEWM]|-?[0-9.]{0,12}|\\PC{0,5}", 0..20),
    ) {
        let line = framed(&([&[name], &fields[..]].concat().join(",")));
        if let Ok(Sentence::Gga(gga)) = parse(&line) {
            prop_assert_eq!(gga.position.is_some(), gga.quality > 0);
        }
    }

    #[test]
    fn a_short_buffer_is_refused(fix in any_fix(), sky in sky(), room: Index) {
        type Writer<'a> = &'a dyn Fn(&mut [u8]) -> Result<usize, NoRoom>;
        let writers: [Writer<'_>; 4] = [
            &|out| write_rmc(&fix, out),
            &|out| write_gga(&fix, out),
            &|out| write_gsa(&fix, &sky, out),
            &|out| write_gsv(&sky, out),
        ];
        for write in writers {
            let needed = written(write).len();
            let room = room.index(needed);
            prop_assert_eq!(write(&mut vec![0; room]), Err(NoRoom { needed, room }));
            prop_assert_eq!(write(&mut vec![0; needed]), Ok(needed));
        }
    }
}

#[test]
fn minutes_are_not_rounded_up_to_sixty() {
    let fix = Fix { latitude_deg: -0.999_999_9, longitude_deg: 179.999_999_9, ..FIX };
    assert!(gga(&fix).contains(",0100.0000,S,18000.0000,E,"), "{}", gga(&fix));
    let fix = Fix { latitude_deg: -0.000_000_1, longitude_deg: -0.5, ..FIX };
    assert!(gga(&fix).contains(",0000.0000,N,00030.0000,W,"), "{}", gga(&fix));
}

#[test]
fn errors_carry_what_disagrees() {
    let error = |fields: &str| parse(&framed(fields)).unwrap_err();
    let field = |index, name| ParseError::Field { index, name };
    for line in ["", "$", "GPRMC*4B", "$GPRMC", "$GPRMC*4b", "$GPRMC*4", "$GPRMC*4B\n", "$GPRMC*4B\r\n\r\n"] {
        assert_eq!(parse(line.as_bytes()), Err(ParseError::Frame), "{line}");
    }
    assert_eq!(parse(b"$GPRMC*00"), Err(ParseError::Checksum { expected: 0x4b, found: 0 }));
    assert_eq!(error("GPRMC"), ParseError::Missing { index: 1, name: "a time" });
    assert_eq!(error("GPRMC,,V,,,,,,"), ParseError::Missing { index: 9, name: "a date" });
    for time in ["0", "240000", "006000", "000061", "00000x", "000000.x", "000000,x", "+00000"] {
        let expected = if time.contains(',') { field(2, "A or V") } else { field(1, "a time") };
        assert_eq!(error(&std::format!("GPRMC,{time},,,,,,,,,")), expected, "{time}");
    }
    assert_eq!(error("GPRMC,,,,,,,,,,"), field(2, "A or V"));
    assert_eq!(error("GPRMC,,A,,,,,,,,"), field(3, "a whole position, as there is a fix"));
    for latitude in ["1", "9000.0001", "0060", "00-1", "00", "001e1", "00inf", "001.2.3"] {
        assert_eq!(error(&std::format!("GPRMC,,A,{latitude},N,00000,E,,,,,,")), field(3, "a latitude"));
    }
    assert_eq!(error("GPRMC,,A,9000,X,00000,E,,,"), field(4, "N or S"));
    assert_eq!(error("GPRMC,,A,9000,N,18000.1,E,,,"), field(5, "a longitude"));
    assert_eq!(error("GPRMC,,A,9000,N,18000,E,-1,,"), field(7, "a speed"));
    assert_eq!(error("GPRMC,,A,9000,N,18000,E,1,361,"), field(8, "a course"));
    assert_eq!(error("GPRMC,,V,,,,,,,000100"), field(9, "a date"));
    assert_eq!(error("GPGGA,,,,,,,,,,"), field(6, "a quality"));
    assert_eq!(error("GPGGA,,,,,,1,,,,"), field(2, "a whole position, as there is a fix"));
    assert_eq!(error("GPGGA,,,,,,0,256,,,"), field(7, "a number of satellites"));
    assert_eq!(error("GPGGA,,,,,,0,,,,F"), field(10, "M"));
    assert_eq!(std::format!("{}", field(10, "M")), "field 10 must be M, and is not");
}

/// A fix whose numbers are all in their fields' ranges.
fn fix() -> impl Strategy<Value = Fix> {
    let when = (0..DAY_MS, (1..=31u8, 1..=12u8, 0..=99u8));
    let place = (-90.0..=90.0, -180.0..=180.0, -9999.0..9999.0);
    let motion = (0.0..5000.0, 0.0..360.0);
    (when, place, motion, 0..=99u8, 0.0..99.0).prop_map(|(when, place, motion, satellites, hdop)| Fix {
        time_utc_ms: when.0,
        date: when.1,
        valid: true,
        latitude_deg: place.0,
        longitude_deg: place.1,
        altitude_m: place.2,
        speed_m_s: motion.0,
        course_deg: motion.1,
        satellites,
        hdop,
        pdop_vdop: None,
    })
}

/// Any numbers at all, but a day and a month that there are.
fn any_fix() -> impl Strategy<Value = Fix> {
    let number = any::<f64>;
    let numbers = (number(), number(), number(), number(), number(), number());
    (fix(), any::<(u32, bool, u8, u8)>(), numbers).prop_map(|(fix, any, numbers)| Fix {
        time_utc_ms: any.0,
        date: (fix.date.0, fix.date.1, any.2),
        valid: any.1,
        latitude_deg: numbers.0,
        longitude_deg: numbers.1,
        altitude_m: numbers.2,
        speed_m_s: numbers.3,
        course_deg: numbers.4,
        hdop: numbers.5,
        pdop_vdop: Some((numbers.5, numbers.5)),
        satellites: any.3,
    })
}

fn sky() -> impl Strategy<Value = Vec<Satellite>> {
    let satellite = any::<(u8, u8, u16, u8)>();
    vec(
        satellite.prop_map(|(prn, elevation_deg, azimuth_deg, snr_db)| Satellite {
            prn,
            elevation_deg,
            azimuth_deg,
            snr_db,
        }),
        0..50,
    )
}
