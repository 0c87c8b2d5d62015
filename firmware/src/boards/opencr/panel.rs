//! The board's user LEDs and buttons, and the voltage of its supply.

use embassy_stm32::Peri;
use embassy_stm32::adc::{Adc, SampleTime};
use embassy_stm32::gpio::{AnyPin, Input, Level, Output, Pull, Speed};
use embassy_stm32::peripherals::{ADC3, PC0};
use embassy_time::{Duration, Instant, Timer};

use crate::tasks::{Reporter, Shared};

/// As often as the stock firmware looks.
const PERIOD: Duration = Duration::from_millis(20);
/// The converter's full scale, V, and its count.
const REFERENCE_V: f32 = 3.3;
const FULL_SCALE: f32 = 4095.0;
/// 47 kΩ over 10 kΩ.
const DIVIDER: f32 = 5.7;

/// What the panel is made of.
pub(super) struct Parts {
    pub(super) leds: [Peri<'static, AnyPin>; 4],
    pub(super) buttons: [Peri<'static, AnyPin>; 2],
    pub(super) converter: Peri<'static, ADC3>,
    pub(super) supply: Peri<'static, PC0>,
}

/// Lit LEDs have their pin low; pressed buttons have theirs high.
pub struct Panel {
    leds: [Output<'static>; 4],
    buttons: [Input<'static>; 2],
    converter: Adc<'static, ADC3>,
    supply: Peri<'static, PC0>,
}

impl Panel {
    pub(super) fn new(parts: Parts) -> Self {
        Self {
            leds: parts.leds.map(|pin| Output::new(pin, Level::High, Speed::Low)),
            buttons: parts.buttons.map(|pin| Input::new(pin, Pull::None)),
            converter: Adc::new(parts.converter),
            supply: parts.supply,
        }
    }

    /// Shows what the host wants and tells what there is, for good.
    pub async fn run(&mut self, shared: &Shared) -> ! {
        loop {
            let count = self.converter.blocking_read(&mut self.supply, SampleTime::CYCLES144);
            let voltage = f32::from(count) * (REFERENCE_V / FULL_SCALE * DIVIDER);
            shared.exchange_panel(|leds| {
                for (led, value) in self.leds.iter_mut().zip(leds) {
                    led.set_level(Level::from(value == 0));
                }
                let pressed = self.buttons.each_ref().map(|button| u8::from(button.is_high()));
                (pressed, Some(voltage))
            });
            shared.report(Reporter::Panel, Instant::now().as_micros());
            Timer::after(PERIOD).await;
        }
    }
}
