// SPDX-License-Identifier: Apache-2.0
// One visit: may this phone measure, may we use the camera, the measurement, the result, its deletion. No screen is in
// here. sdk/kotlin/sample-app has the same steps.
import ARKit
import AVFoundation
import Foundation
import Im2fit

/// What the screen shows.
enum Step {
    case unsupported  // no LiDAR: said before anybody undresses
    case permission   // the camera's permission is needed
    case ready        // what happens, and a button that consents to it
    case measuring
    case result
    case notMeasured  // stopped too early; `guidance` says what was in the way
    case failed
}

/// All that a screen needs.
struct Shown {
    var step: Step
    var progress: FitProgress?
    var mask: Mask?
    var values: [String: Estimate] = [:]
    var size = ""
    var guidance: [String] = []
    var failure = ""
}

/// Functions are to be called on the main thread, where `shown` changes. Frames come on a queue of their own.
final class Measuring: NSObject, ObservableObject, ARSessionDelegate {
    @Published private(set) var shown: Shown
    private let pack: URL
    private let camera = ARSession()
    private let queue = DispatchQueue(label: "depth camera")
    // The queue's alone.
    private var session: FitSession?
    private var wantsTurn = false
    private var visit = 0
    private var sequence: UInt64 = 0
    // The main thread's: what a camera that was stopped still reports belongs to an earlier visit.
    private var current = 0

    /// `pack`: the model pack in the app's bundle.
    init(pack: URL) {
        self.pack = pack
        let available = ARWorldTrackingConfiguration.supportsFrameSemantics(.sceneDepth)
        shown = Shown(step: available ? .permission : .unsupported)
        super.init()
        camera.delegate = self
        camera.delegateQueue = queue
        if AVCaptureDevice.authorizationStatus(for: .video) == .authorized { granted(true) }
    }

    /// The person's answer to the question for the camera.
    func granted(_ yes: Bool) {
        if shown.step == .permission && yes { shown = Shown(step: .ready) }
    }

    /// Asks for the camera.
    func ask() {
        AVCaptureDevice.requestAccess(for: .video) { yes in DispatchQueue.main.async { self.granted(yes) } }
    }

    /// The person consents. `turn`: with a slow turn on the spot, which measures waist and hip better.
    func start(turn: Bool) {
        guard [.ready, .notMeasured, .failed].contains(shown.step) else { return }
        current += 1
        let mine = current
        shown = Shown(step: .measuring)
        queue.async {
            self.session = nil  // made with the first frame, which has the camera's intrinsics
            self.wantsTurn = turn
            self.visit = mine
            self.sequence = 0
        }
        let configuration = ARWorldTrackingConfiguration()
        configuration.frameSemantics = .sceneDepth
        camera.run(configuration, options: [.resetTracking])
    }

    /// Ends with the frames so far.
    func stop() {
        queue.async {
            guard let session = self.session else { return }
            self.conclude(session, self.visit)
        }
    }

    /// Nothing of the person is left: no file was written, and the session with its frames is gone.
    func delete() {
        stopCamera()
        if shown.step != .unsupported && shown.step != .permission { shown = Shown(step: .ready) }
    }

    /// The app is not on the screen any more: the camera goes off, and a measurement that has begun is dropped.
    func leave() {
        let measuring = shown.step == .measuring
        stopCamera()
        if measuring { shown = Shown(step: .ready) }
    }

    private func stopCamera() {
        current += 1
        camera.pause()
        queue.async {
            self.visit = 0  // frames that were on their way are nobody's
            self.session = nil
        }
    }

    // On the queue from here on.

    func session(_ camera: ARSession, didUpdate frame: ARFrame) {
        guard visit > 0 else { return }
        do {
            guard let session = try self.session ?? open(frame) else { return }
            self.session = session
            guard try session.push(frame, sequence: sequence) else { return }
            sequence += 1
            let progress = try session.progress()
            if progress.state == "MEASURED" {
                conclude(session, visit)
            } else {
                let mask = try session.mask()
                report(visit) { self.shown = Shown(step: .measuring, progress: progress, mask: mask) }
            }
        } catch {
            fail(error, visit)
        }
    }

    func session(_ camera: ARSession, didFailWithError error: Error) { fail(error, visit) }

    private func open(_ frame: ARFrame) throws -> FitSession? {
        var settings = FitSettings()
        settings.turn = wantsTurn ? .around : .none
        settings.sensor = .timeOfFlight
        return try FitSession(frame, pack: pack, settings: settings)
    }

    private func conclude(_ session: FitSession, _ mine: Int) {
        do {
            switch try session.finish() {
            case .measured(let values):
                let (sizes, best) = try session.sizes()
                let size = sizes.indices.contains(best) ? sizes[best].name : ""
                end(mine, Shown(step: .result, values: values, size: size))
            case .notMeasured(_, let guidance):
                end(mine, Shown(step: .notMeasured, guidance: guidance))
            }
        } catch {
            fail(error, mine)
        }
    }

    private func fail(_ error: Error, _ mine: Int) {
        end(mine, Shown(step: .failed, failure: (error as? Im2fitError)?.description ?? error.localizedDescription))
    }

    private func end(_ mine: Int, _ last: Shown) {
        visit = 0
        self.session = nil
        report(mine) {
            self.stopCamera()
            self.shown = last
        }
    }

    private func report(_ mine: Int, _ what: @escaping () -> Void) {
        DispatchQueue.main.async { if mine == self.current && self.shown.step == .measuring { what() } }
    }
}
