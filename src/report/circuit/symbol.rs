//! Symbols after ISO 1219-1, drawn for a flow upwards around (0, 0); colours come from the page.

use crate::physics::card::Card;
use crate::physics::component::facts;
pub(super) use crate::physics::component::facts::Symbol;

/// The symbol of a component.
pub(super) fn of(card: &Card) -> Symbol {
    facts(card).symbol
}

/// Lines that reach both ends.
const THROUGH: &str = "M0 30V-30";

/// What a symbol takes of the drawing.
#[derive(Clone, Copy)]
struct Shape {
    half_width: f64,
    half_height: f64,
    /// Whether it may stand upside down.
    turns: bool,
    /// Where the hydraulic ports end, in the order of the card.
    ends: &'static [(f64, f64)],
}

impl Shape {
    /// Two ports in line; those that formulas add to them stand at the sides.
    const USUAL: Self = Self {
        half_width: 24.0,
        half_height: 26.0,
        turns: true,
        ends: &[(0.0, 30.0), (0.0, -30.0), (-20.0, 0.0), (20.0, 0.0)],
    };
}

impl Symbol {
    pub fn is_source(self) -> bool {
        matches!(self, Self::Pump | Self::VariablePump | Self::ReversiblePump)
    }

    /// Whether it may stand upside down.
    pub fn turns(self) -> bool {
        self.shape().turns
    }

    pub fn half_width(self) -> f64 {
        self.shape().half_width
    }

    pub fn half_height(self) -> f64 {
        self.shape().half_height
    }

    /// How far the symbol reaches to the left.
    pub fn left(self) -> f64 {
        if self == Self::Cylinder { 62.0 } else { self.half_width() }
    }

    /// Where the hydraulic ports end, in the order of the card.
    pub fn ends(self) -> &'static [(f64, f64)] {
        self.shape().ends
    }

    fn shape(self) -> Shape {
        let usual = Shape::USUAL;
        match self {
            Self::Pump | Self::VariablePump | Self::ReversiblePump => {
                // Outlet and inlet.
                Shape { turns: false, ends: &[(0.0, -30.0), (0.0, 30.0), (-22.0, 0.0), (22.0, 0.0)], ..usual }
            }
            Self::PilotCheckValve => Shape { ends: &[(0.0, 30.0), (0.0, -30.0), (-24.0, 0.0)], ..usual },
            Self::DirectionalValve => {
                let ends = &[(-10.0, 30.0), (10.0, 30.0), (-10.0, -30.0), (10.0, -30.0)];
                Shape { half_width: 78.0, turns: false, ends, ..usual }
            }
            Self::OnOffValve => Shape { half_width: 78.0, ..usual },
            Self::Cylinder => {
                Shape { half_width: 100.0, half_height: 20.0, turns: false, ends: &[(-48.0, 30.0), (48.0, 30.0)] }
            }
            // The case drains beside the circle.
            Self::Motor => Shape { ends: &[(0.0, 30.0), (0.0, -30.0), (-40.0, 10.0)], ..usual },
            Self::Vessel => Shape { half_width: 36.0, half_height: 34.0, turns: false, ends: &[(0.0, 34.0)] },
            Self::Accumulator => Shape { turns: false, ends: &[(0.0, 30.0)], ..usual },
            Self::ReliefValve | Self::BypassFilter => Shape { half_width: 36.0, ..usual },
            Self::FlowControlValve
            | Self::CheckValve
            | Self::Restrictor
            | Self::Orifice
            | Self::OneWayThrottle
            | Self::Filter
            | Self::FreeOutlet
            | Self::Box
            | Self::Hidden
            | Self::Force => usual,
        }
    }

    /// Lines of the symbol; the middle square of a directional valve is empty, what its centre connects is its own.
    pub fn svg(self) -> String {
        let line = |d: &str| format!("<path d=\"{d}\"/>");
        let full = |d: &str| format!("<path class=\"full\" d=\"{d}\"/>");
        match self {
            Self::Hidden | Self::Force => String::new(),
            Self::Pump => {
                "<circle r=\"22\"/>".to_owned() + &line("M0-22V-30M0 22V30M-22-3H-34M-22 3H-34") + &full("M0-22L-8-9H8z")
            }
            Self::VariablePump => {
                Self::Pump.svg() + &line("M-20 20L24-20M24-20l-9 3M24-20l-4 9")
            }
            Self::ReversiblePump => Self::Pump.svg() + &full("M0 22L-8 9H8z"),
            Self::ReliefValve => {
                "<rect x=\"-18\" y=\"-18\" width=\"36\" height=\"36\"/>".to_owned()
                    + &line("M0 18V30M0-18V-30M-8 13V-13M-8-13l-4 7M-8-13l4 7M18 0l2-6 4 12 4-12 4 12 2-6")
                    + "<path class=\"pilot\" d=\"M0 25H-27V0H-18\"/>"
            }
            Self::FlowControlValve => {
                "<rect x=\"-20\" y=\"-22\" width=\"40\" height=\"44\"/>".to_owned()
                    + &line(THROUGH)
                    + &line("M-10-9Q-2 0-10 9M10-9Q2 0 10 9M0-20l-4 7M0-20l4 7M-24 14L24-14M24-14l-8 1M24-14l-5 6")
            }
            Self::DirectionalValve => {
                let squares: String = [-60, -20, 20]
                    .iter()
                    .map(|x| format!("<rect x=\"{x}\" y=\"-20\" width=\"40\" height=\"40\"/>"))
                    .collect();
                squares
                    + "<rect x=\"-76\" y=\"-9\" width=\"16\" height=\"18\"/><rect x=\"60\" y=\"-9\" width=\"16\" height=\"18\"/>"
                    + &line("M-76 9L-60-9M60 9L76-9M-10 20V30M10 20V30M-10-20V-30M10-20V-30")
                    + &line("M-50 20V-20M-50-20l-4 8M-50-20l4 8M-30-20V20M-30 20l-4-8M-30 20l4-8")
                    + &line("M30 20L50-20M50-20l-7 6M50-20l0 9M30-20L50 20M50 20l-7-6M50 20l0-9")
            }
            Self::CheckValve => "<circle r=\"8\"/>".to_owned() + &line("M0-8V-30M-12-1L0 11 12-1M0 11V30"),
            Self::PilotCheckValve => Self::CheckValve.svg() + "<path class=\"pilot\" d=\"M-24 0H-9\"/>",
            Self::OnOffValve => {
                "<rect x=\"-60\" y=\"-20\" width=\"40\" height=\"40\"/><rect x=\"-20\" y=\"-20\" width=\"40\" height=\"40\"/>\
                 <rect x=\"-76\" y=\"-9\" width=\"16\" height=\"18\"/>"
                    .to_owned()
                    + &line("M-76 9L-60-9M0 20V30M0-20V-30M0 20v-8m-5 0h10M0-20v8m-5 0h10M-40 20V-20M-40-20l-4 8M-40-20l4 8")
                    + &line("M20 0l4-6 5 12 5-12 5 12 5-6")
            }
            Self::Restrictor => line(THROUGH) + &line("M-12-15Q-1 0-12 15M12-15Q1 0 12 15"),
            Self::OneWayThrottle => {
                line(THROUGH)
                    // The ball lifts off its seat towards the inlet.
                    + &line("M-12-15Q-1 0-12 15M12-15Q1 0 12 15M0 24H26V8M26-7V-24H0M19 4L26-7 33 4")
                    + "<circle cx=\"26\" cy=\"2\" r=\"6\"/>"
            }
            Self::Filter => line("M0-18L18 0 0 18-18 0zM0-18V-30M0 18V30") + "<path class=\"pilot\" d=\"M-18 0H18\"/>",
            Self::BypassFilter => {
                Self::Filter.svg()
                    + &line("M0 24H28V7M28-8l-4-2 8-3-8-3 4-2V-24H0M21-4L28 7 35-4")
                    + "<circle cx=\"28\" cy=\"-2\" r=\"6\"/>"
            }
            Self::Motor => "<circle r=\"22\"/>".to_owned() + &line("M0-22V-30M0 22V30M22-3H34M22 3H34M-20 10H-40") + &full("M0 8L-8 21H8z"),
            Self::Orifice => line(THROUGH) + &line("M-13-9L-3 0-13 9M13-9L3 0 13 9"),
            Self::FreeOutlet => line("M0 30V-8") + &line("M-13-9L-3 0-13 9M13-9L3 0 13 9") + "<path class=\"pilot\" d=\"M0-8V-30\"/>",
            Self::Cylinder => {
                "<rect x=\"-60\" y=\"-17\" width=\"120\" height=\"34\"/><rect class=\"full\" x=\"-24\" y=\"-17\" width=\"7\" height=\"34\"/>\
                 <rect class=\"rod\" x=\"-17\" y=\"-4\" width=\"115\" height=\"8\"/>"
                    .to_owned()
                    + &line("M-48 17V30M48 17V30")
            }
            Self::Accumulator => {
                "<rect x=\"-12\" y=\"-24\" width=\"24\" height=\"46\" rx=\"12\"/>".to_owned() + &line("M-12-2H12M0 22V30") + &full("M-5-16H5L0-8z")
            }
            Self::Vessel => line("M-34-28V26H34V-28M0 26V34") + &line("M-34-6H34") + &full("M-4-14H4L0-7z"),
            Self::Box => "<rect x=\"-20\" y=\"-18\" width=\"40\" height=\"36\"/>".to_owned() + &line("M0 18V30M0-18V-30M-10-6H10M-10 0H10M-10 6H10"),
        }
    }
}
