// SPDX-License-Identifier: Apache-2.0
// What the person sees at each step. The words of the guidance and of the tape are the library's.
import Im2fit
import SwiftUI

@main
struct SampleApp: App {
    @StateObject private var measuring = Measuring(
        pack: Bundle.main.url(forResource: "im2fit-models", withExtension: "i2p")!)
    @Environment(\.scenePhase) private var phase

    var body: some Scene {
        WindowGroup {
            Screen(measuring: measuring)
                .onChange(of: phase) { now in if now == .background { measuring.leave() } }
        }
    }
}

/// One of the languages that the library has texts in.
let language: String = {
    let own = Locale.current.languageCode ?? "en"
    return ["de", "es", "fr", "zh"].contains(own) ? own : "en"
}()

struct Screen: View {
    @ObservedObject var measuring: Measuring

    var body: some View {
        switch measuring.shown.step {
        case .measuring: MeasuringScreen(measuring: measuring)
        case .result: ResultScreen(measuring: measuring)
        default: WordsScreen(measuring: measuring)
        }
    }
}

struct WordsScreen: View {
    @ObservedObject var measuring: Measuring

    var body: some View {
        ScrollView {
            VStack(alignment: .leading, spacing: 16) {
                Text("im2fit sample").font(.title)
                switch measuring.shown.step {
                case .unsupported:
                    Text("This phone has no LiDAR, so it cannot measure. Nothing else is needed from you.")
                case .permission:
                    Text("The app measures with the depth camera. Please allow it.")
                    Button("Allow the camera") { measuring.ask() }
                case .notMeasured:
                    Text("Not measured yet. What was in the way:")
                    ForEach(measuring.shown.guidance, id: \.self) { Text(guidanceText($0, language: language) ?? $0) }
                case .failed:
                    Text("The measurement failed: \(measuring.shown.failure)")
                default:
                    Text("The camera measures your body on this phone. No picture is kept, and nothing is sent. "
                        + "Delete removes the result at once.")
                }
                if [.ready, .notMeasured, .failed].contains(measuring.shown.step) {
                    Text("Wear underwear or close-fitting sportswear. Lean the phone upright at hip height, step back about "
                        + "two and a half metres, and hold your arms a little away from your body.")
                    Button("I agree: measure with one slow turn") { measuring.start(turn: true) }
                    Button("I agree: measure the front only") { measuring.start(turn: false) }
                }
            }.padding(24)
        }
    }
}

/// The person's outline, the most urgent request, and how far it is.
struct MeasuringScreen: View {
    @ObservedObject var measuring: Measuring

    var body: some View {
        let progress = measuring.shown.progress
        ZStack {
            Color(white: 0.08).ignoresSafeArea()
            if let mask = measuring.shown.mask, let picture = picture(mask) {
                Image(decorative: picture, scale: 1).resizable().scaledToFit()
            }
            if let progress = progress, progress.state == "TURNING" { TurnRing(turnedDeg: progress.turnedDeg) }
            VStack {
                Text(request(progress)).font(.title)
                Spacer()
                ProgressView(value: share(progress))
                Button("Stop") { measuring.stop() }
            }.padding(24).foregroundColor(.white)
        }
    }
}

/// A ring that fills as the person turns: clockwise to the person's left, the other way to the right.
struct TurnRing: View {
    let turnedDeg: Float

    var body: some View {
        ZStack {
            Circle().stroke(Color.gray, lineWidth: 16)
            Circle().trim(from: 0, to: CGFloat(min(abs(turnedDeg), 360) / 360))
                .stroke(Color.green, lineWidth: 16)
                .rotationEffect(.degrees(-90))
                .scaleEffect(x: turnedDeg < 0 ? -1 : 1, y: 1)
        }.padding(48)
    }
}

struct ResultScreen: View {
    @ObservedObject var measuring: Measuring

    var body: some View {
        let names = Dictionary(uniqueKeysWithValues: tapeDefinitions(language: language).map { ($0.id, $0.name) })
        ScrollView {
            VStack(alignment: .leading, spacing: 8) {
                Text("Your size: \(measuring.shown.size)").font(.title)
                ForEach(measuring.shown.values.sorted { $0.key < $1.key }, id: \.key) { id, value in
                    Text("\(names[id] ?? id): \(shownNumber(id, value.value)) "
                        + "(\(shownNumber(id, value.low)) to \(shownNumber(id, value.high))) \(shownUnit(id))")
                }
                Text("In brackets: where the true value lies in 95 of 100 measurements.")
                Button("Delete") { measuring.delete() }
            }.padding(24)
        }
    }
}

/// The first thing the person should do; nothing to do: that it measures.
func request(_ progress: FitProgress?) -> String {
    progress?.guidance.first.flatMap { guidanceText($0, language: language) } ?? "Hold still"
}

/// From 0 to 1.
func share(_ progress: FitProgress?) -> Float {
    guard let progress = progress else { return 0 }
    if progress.state == "TURNING" { return min(abs(progress.turnedDeg) / 360, 1) }
    return progress.framesWanted == 0 ? 0 : min(Float(progress.framesUsed) / Float(progress.framesWanted), 1)
}

/// Lengths in cm.
func shownNumber(_ id: String, _ value: Float) -> String {
    String(Int((unit(ofMeasurement: id) == "mm" ? value / 10 : value).rounded()))
}

func shownUnit(_ id: String) -> String { unit(ofMeasurement: id) == "mm" ? "cm" : unit(ofMeasurement: id) ?? "" }

/// The person as a light shape; all else is clear.
func picture(_ mask: Mask) -> CGImage? {
    let grey = mask.pixels.map { $0 == 0 ? UInt8(20) : UInt8(200) }
    guard let data = CGDataProvider(data: Data(grey) as CFData) else { return nil }
    return CGImage(width: mask.width, height: mask.height, bitsPerComponent: 8, bitsPerPixel: 8, bytesPerRow: mask.width,
                   space: CGColorSpaceCreateDeviceGray(), bitmapInfo: CGBitmapInfo(rawValue: 0), provider: data, decode: nil,
                   shouldInterpolate: false, intent: .defaultIntent)
}
