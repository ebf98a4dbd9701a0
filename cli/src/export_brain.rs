//! `baudbot export-brain`: a brain as a file for a robot's own microcontroller.

use baudbot_brains::catalogue;
use baudbot_client::Body;

use crate::args::{ExportBrainArgs, ExportLanguage};
use crate::error::Refused;
use crate::output_files::Inputs;
use crate::run::overrides;
use crate::scenarios::Source;
use crate::text;

pub(crate) fn export_brain(args: &ExportBrainArgs) -> anyhow::Result<()> {
    let inputs = Inputs::of(&args.scenario, &args.changes).brains(std::slice::from_ref(&args.brain));
    inputs.check([("--out", args.out.as_path())].into_iter())?;
    let scenario = Source::find(&args.scenario)?.parse(&overrides(&args.changes)?)?;
    let named = |name: &String| scenario.robots.iter().find(|robot| robot.name == *name);
    let robot = args.robot.as_ref().map_or_else(|| scenario.robots.first(), named);
    let Some(robot) = robot else {
        let names = scenario.robots.iter().map(|robot| robot.name.as_str()).collect::<Vec<_>>().join(", ");
        return Err(Refused::error(match &args.robot {
            Some(name) => format!("--robot: there is no robot `{name}`; there are: {names}"),
            None => format!("scenario `{}` has no robots", args.scenario),
        }));
    };
    let file = match args.lang {
        ExportLanguage::C => catalogue::c_file(&args.brain, scenario.seed, &Body::from(robot)),
    };
    text::write(&args.out, &file.map_err(|error| Refused::error(error.to_string()))?)
}
