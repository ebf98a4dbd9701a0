//! `baudbot port watch`: the bytes of a cable with their meaning, row by row, as the page shows them.

use anyhow::Context;
use baudbot_fields::printable::Printable;
use baudbot_plot::quantity::duration;
use baudbot_proto::v1;

use crate::args::WatchPortArgs;
use crate::connect;
use crate::error::from_server;
use crate::signals::Stop;
use crate::text::{self, tell};

/// `baudbot port watch`.
pub(crate) async fn watch(args: &WatchPortArgs) -> anyhow::Result<()> {
    let mut stop = Stop::listen().context("cannot listen for Ctrl-C")?;
    tokio::select! {
        shown = show(args) => shown,
        () = stop.wait() => Ok(()),
    }
}

async fn show(args: &WatchPortArgs) -> anyhow::Result<()> {
    let channel = connect::channel(&args.server).await?;
    let world = connect::world(channel.clone(), &args.server).await?.world;
    let (robot, sensor) = args.cable.split_once('/').unwrap_or((&args.cable, ""));
    let (robot, sensor) = (robot.to_owned(), sensor.to_owned());
    let request = v1::WatchCableRequest { world, robot, sensor };
    let news = connect::observe(channel).watch_cable(request).await;
    let mut news = news.map_err(|status| from_server(&status))?.into_inner();
    let (mut missed, mut rows) = (0, 0);
    while let Some(news) = news.message().await.map_err(|status| from_server(&status))? {
        if news.restarted {
            tell!("the world is at another time");
        }
        if news.missed_items > missed {
            tell!("{} items were left out", news.missed_items - missed);
            missed = news.missed_items;
        }
        let most = args.rows.map_or(u64::MAX, |most| most - rows);
        let shown: Vec<_> =
            news.items.iter().take(usize::try_from(most).unwrap_or(usize::MAX)).map(row).collect();
        rows += shown.len() as u64;
        text::print(&shown.concat())?;
        if args.rows == Some(rows) {
            return Ok(());
        }
    }
    Ok(())
}

/// A row: the instant of the last byte in milliseconds, the direction, the bytes, the meaning, and the age of the oldest
/// reading.
fn row(item: &v1::CableItem) -> String {
    let at_ms = item.to_ns as f64 * 1e-6;
    let way = match item.direction() {
        v1::CableDirection::Up => "up  ",
        v1::CableDirection::Down => "down",
        v1::CableDirection::Unspecified => "    ",
    };
    let mut hex: Vec<_> = item.data.iter().take(MOST_HEX).map(|byte| format!("{byte:02x}")).collect();
    if item.size as usize > hex.len() {
        hex.push(format!("+ {}", item.size as usize - hex.len()));
    }
    let age = item.age_ns.map_or_else(String::new, |ns| format!("  [{} old]", duration(ns as f64)));
    format!("{at_ms:>12.3}  {way}  {:<23}  {}{age}\n", hex.join(" "), Printable(&item.text))
}

/// Bytes of a row that are shown.
const MOST_HEX: usize = 16;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_has_an_instant_a_direction_bytes_and_their_meaning() {
        let item = v1::CableItem {
            direction: v1::CableDirection::Up.into(),
            from_ns: 1_000_000,
            to_ns: 2_041_667,
            data: b"n,1\r\n".to_vec(),
            size: 5,
            text: "n: proximity 1".to_owned(),
            understood: true,
            age_ns: Some(20_500_000),
        };
        let expected = "       2.042  up    6e 2c 31 0d 0a           n: proximity 1  [20.5 ms old]\n";
        assert_eq!(row(&item), expected);
        let long = v1::CableItem { data: vec![0; 4096], size: 9000, age_ns: None, ..item };
        assert!(row(&long).contains(" 00 + 8984  n: proximity 1\n"), "{}", row(&long));
    }
}
