// SPDX-License-Identifier: Apache-2.0
import CIm2fit
import Foundation

/// A call of the library failed. `status` is the number of the status in im2fit.h.
public struct Im2fitError: Error, CustomStringConvertible {
    public let status: Int32
    public let description: String
}

/// A value with its 95 % interval: mm; weight: kg.
public struct Estimate: Equatable, Sendable {
    public let value, low, high: Float
}

/// Lens distortion, which the library corrects: the Brown-Conrady model of OpenCV, radial k1 to k3, tangential p1 and p2.
/// ARKit's depth has none.
public struct Lens: Equatable, Sendable {
    public var k1, k2, k3, p1, p2: Float
    public init(k1: Float = 0, k2: Float = 0, k3: Float = 0, p1: Float = 0, p2: Float = 0) {
        (self.k1, self.k2, self.k3, self.p1, self.p2) = (k1, k2, k3, p1, p2)
    }
}

/// The depth camera, in pixels of the upright picture. The centre of pixel 0 is 0.
public struct CameraModel: Sendable {
    public var width, height: Int32
    public var fx, fy, cx, cy: Float
    public init(width: Int32, height: Int32, fx: Float, fy: Float, cx: Float, cy: Float) {
        (self.width, self.height, self.fx, self.fy, self.cx, self.cy) = (width, height, fx, fy, cx, cy)
    }
}

/// The progress after the latest processed frame. Names are those of im2fit.h: "TRACKING", "ARMS_CLOSE".
public struct FitProgress: Equatable, Sendable {
    public let state: String
    public let guidance: [String]
    public let view: String          // the side of the person that faces the camera: "front", "back", "side", "unknown"
    public let userId: Int32         // the person of the guidance; 0: no person is in view
    public let framesUsed: UInt64
    public let framesWanted: Int32   // for a progress bar: framesUsed of it; with Turn.back it counts for each side
    public let turnedDeg: Float      // Turn.around: the farthest that the person has turned; positive to their left
}

/// The mask of the person in a frame: rows from the top of the upright picture, 255 the person, 0 everything else.
public struct Mask: Equatable, Sendable {
    public let width, height: Int
    public let pixels: [UInt8]
    public let userId: Int32     // 0: no person is in view, and the mask is empty
    public let sequence: UInt64  // of the frame
    public let timeNs: Int64
}

/// The text for a guidance code ("TOO_NEAR"), at most six words; nil for another code or language. `language`:
/// "en", "de", "es", "fr" or "zh".
public func guidanceText(_ code: String, language: String = "en") -> String? {
    (0..<Int32(IM2FIT_GUIDANCE_COUNT)).first { im2fit_guidance_name($0).map { String(cString: $0) } == code }
        .flatMap { im2fit_guidance_text($0, language) }.map { String(cString: $0) }
}

/// What is measured in addition to the front. Numbers of IM2FIT_TURN_...
public enum Turn: Int32, Sendable {
    case none = 0    // nothing
    case back = 1    // the back, once the person has turned it to the camera
    case around = 2  // all round: one slow turn on the spot; needs a body
    case walk = 3    // the same, of a person who stands still, with a phone that is carried round; needs poses
}

/// What the person wears. Numbers of IM2FIT_CLOTHING_...
public enum Clothing: Int32, Sendable {
    case estimated = 0  // from the frames, given a body
    case bare = 1       // underwear or close-fitting sportswear
    case dressed = 2    // the body underneath is measured, with wider intervals
}

/// How the camera senses depth. Numbers of IM2FIT_SENSOR_...
public enum DepthSensor: Int32, Sendable {
    case judged = 0     // from the frames
    case structuredLight = 1
    case timeOfFlight = 2
    case stereo = 3     // RealSense D400, OAK-D
}

/// Settings of a session. The defaults are those of the library, except `live`.
public struct FitSettings: Equatable, Sendable {
    public var framesWanted: Int32 = 15  // accepted frames until the measurement, 1..1000; with Turn.back for each side
    public var framesMin: Int32 = 5      // fewest accepted frames for `finish()` to measure
    public var live = true               // true: the oldest frame is dropped when the library is behind; false: `push` waits
    public var turn = Turn.none          // what the person is asked to do once the front is accumulated
    public var clothing = Clothing.estimated
    public var sensor = DepthSensor.judged
    public var calibrationPose = false   // true: the person raises the arms first
    public init() {}
}

/// Focal lengths and principal point of one frame, in pixels of the frame as delivered; the centre of pixel 0 is 0.
public struct Intrinsics: Equatable, Sendable {
    public var fx, fy, cx, cy: Float
    public init(fx: Float, fy: Float, cx: Float, cy: Float) {
        (self.fx, self.fy, self.cx, self.cy) = (fx, fy, cx, cy)
    }
    /// Scales the intrinsics to another width: ARKit's are those of the colour picture, and its depth picture is smaller.
    public func scaled(fromWidth: Int, toWidth: Int) -> Intrinsics {
        let scale = Float(toWidth) / Float(fromWidth)
        return Intrinsics(fx: fx * scale, fy: fy * scale, cx: (cx + 0.5) * scale - 0.5, cy: (cy + 0.5) * scale - 0.5)
    }
}

/// The pose of a hand-held camera: the unit quaternion from the axes of the frame as delivered (x right, y down, z forward) to
/// static axes, and the position of the camera in the static axes, mm.
public struct CameraPose: Equatable, Sendable {
    public var x, y, z, w: Float
    public var placeMm: SIMD3<Float>
    public init(x: Float, y: Float, z: Float, w: Float, placeMm: SIMD3<Float> = .zero) {
        (self.x, self.y, self.z, self.w, self.placeMm) = (x, y, z, w, placeMm)
    }
    /// From ARKit's `ARCamera.transform`, whose axes have y up and z backwards: its rotation as a quaternion x, y, z, w
    /// (`simd_quatf(transform).vector`) and its last column, metres.
    public init(arkit q: SIMD4<Float>, metres: SIMD3<Float>) {
        self.init(x: q.w, y: q.z, z: -q.y, w: -q.x, placeMm: metres * 1000)
    }
}

/// How a size fits in a region.
public struct PlaceFit: Equatable, Sendable {
    public let place: String        // "chest"
    public let easeMm: Estimate     // girth of the finished garment minus girth of the body
    public let verdict: String      // "tight", "snug", "good", "loose"
}

/// How a size of a garment fits.
public struct SizeFit: Equatable, Sendable {
    public let size: String
    public let places: [PlaceFit]
}

/// A pose for the nodes of an avatar's .glb: the translation of node 0 in metres, and the rotation of every node, x y z w.
public struct Rig: Equatable, Sendable {
    public let root: SIMD3<Float>
    public let rotations: [SIMD4<Float>]
}

/// Describes the models, for a support page or to check that they have the required features.
public struct ModelInfo: Equatable, Sendable {
    public let madeBy: String        // the program that made the index, and its source data
    public let people: UInt32        // number of people in the index
    public let captures: UInt32      // number of captures of these people
    public let trackerKey: UInt32    // opening refuses an index made with another tracker
    public let hasBody: Bool         // meshes, tape, avatars and garments are available
    public let answersShape: Bool    // a shape is fitted to the depth; false: less accurate
    public let answersTurned: Bool   // the index covers people from behind
    public let answersClothed: Bool  // the index covers people in clothes
    public let siteCorrected: Bool   // measurements are corrected for the site
}

/// How a session ended.
public enum Outcome: Sendable {
    /// Values by name ("chest_girth").
    case measured([String: Estimate])
    case notMeasured(state: String, guidance: [String])
}

/// Measures one person with one depth camera. Only one thread at a time may use a session: keep it in an actor or a queue. It
/// is not Sendable. Exception: any thread may call `progress()` and `mask()` while the session exists.
public final class FitSession {
    let handle: OpaquePointer

    /// Without `body` (nil) the JSON lacks the body, and there is no avatar.
    public init(camera: CameraModel, tracker: URL, index: URL, body: URL? = nil,
                settings wanted: FitSettings = FitSettings()) throws {
        var opened: OpaquePointer?
        let status: Int32 = tracker.path.withCString { tracker in
            index.path.withCString { index in
                FitSession.withOptional(body?.path) { body in
                    var settings = im2fit_settings()
                    im2fit_settings_init(&settings, MemoryLayout<im2fit_settings>.size)
                    settings.tracker_path = tracker
                    settings.index_path = index
                    settings.body_path = body
                    settings.width = camera.width
                    settings.height = camera.height
                    (settings.fx, settings.fy, settings.cx, settings.cy) = (camera.fx, camera.fy, camera.cx, camera.cy)
                    settings.frames_wanted = wanted.framesWanted
                    settings.frames_min = wanted.framesMin
                    settings.live = wanted.live ? 1 : 0
                    settings.turn = wanted.turn.rawValue
                    settings.clothing = wanted.clothing.rawValue
                    settings.sensor = wanted.sensor.rawValue
                    settings.calibration_psi = wanted.calibrationPose ? 1 : 0
                    return im2fit_open(&settings, &opened)
                }
            }
        }
        guard status == 0, let opened = opened else {
            throw Im2fitError(status: status, description: String(cString: im2fit_last_error(nil)))
        }
        handle = opened
    }

    /// Models of one pack (.i2p).
    public convenience init(camera: CameraModel, pack: URL, settings: FitSettings = FitSettings()) throws {
        try self.init(camera: camera, tracker: pack, index: pack, body: pack, settings: settings)
    }

    deinit { im2fit_close(handle) }

    /// Processes one frame. `metres`: depth as ARKit and AVFoundation deliver it, 32-bit metres, NaN or 0: no data.
    /// `rotateDeg`: clockwise rotation that makes it upright. `down`: the direction of gravity in the axes of this picture
    /// (x right, y down, z forward); zero: unknown. `lens`: distortion that is not yet corrected. `pose`: pose of a hand-held
    /// camera. `confidence`: one byte per sample; samples below `confidenceMin` count as no data (ARKit's `confidenceMap` has 0,
    /// 1, 2). `intrinsics`: of this frame, because they change with focus; nil: those of the session.
    public func push(metres: UnsafePointer<Float>, width: Int32, height: Int32, rowBytes: Int = 0, rotateDeg: Int32 = 0,
                     timeNs: Int64 = 0, sequence: UInt64 = 0, down: SIMD3<Float> = .zero, lens: Lens = Lens(),
                     pose: CameraPose? = nil, confidence: UnsafePointer<UInt8>? = nil, confidenceRowBytes: Int = 0,
                     confidenceMin: Int32 = 0, intrinsics: Intrinsics? = nil) throws {
        var frame = im2fit_frame()
        im2fit_frame_init(&frame, MemoryLayout<im2fit_frame>.size)
        frame.pixels = UnsafeRawPointer(metres)
        frame.format = Int32(IM2FIT_FORMAT_F32.rawValue)
        frame.width = width
        frame.height = height
        frame.rotate_deg = rotateDeg
        frame.row_bytes = rowBytes
        frame.time_ns = timeNs
        frame.sequence = sequence
        (frame.down_x, frame.down_y, frame.down_z) = (down.x, down.y, down.z)
        (frame.k1, frame.k2, frame.k3, frame.p1, frame.p2) = (lens.k1, lens.k2, lens.k3, lens.p1, lens.p2)
        frame.confidence = confidence
        frame.confidence_row_bytes = confidenceRowBytes
        frame.confidence_min = confidenceMin
        if let k = intrinsics { (frame.fx, frame.fy, frame.cx, frame.cy) = (k.fx, k.fy, k.cx, k.cy) }
        if let pose = pose {
            (frame.turn_x, frame.turn_y, frame.turn_z, frame.turn_w) = (pose.x, pose.y, pose.z, pose.w)
            (frame.x_mm, frame.y_mm, frame.z_mm) = (pose.placeMm.x, pose.placeMm.y, pose.placeMm.z)
        }
        try check(im2fit_push_frame(handle, &frame))
    }

    public func progress() throws -> FitProgress {
        let result = try poll()
        return FitProgress(state: FitSession.text(im2fit_state_name(result.state)),
                           guidance: FitSession.codes(result.guidance), view: FitSession.text(im2fit_view_name(result.view)),
                           userId: result.user_id, framesUsed: result.frames_used, framesWanted: result.frames_wanted,
                           turnedDeg: result.turned_deg)
    }

    /// The mask of the person in the latest frame; nil until the first frame after the first call. Any thread.
    public func mask() throws -> Mask? {
        var info = im2fit_mask_info()
        let infoSize = MemoryLayout<im2fit_mask_info>.size
        let status = im2fit_mask(handle, nil, 0, &info, infoSize)
        if status == Int32(IM2FIT_ERROR_NOT_FOUND.rawValue) { return nil }
        try check(status)
        var pixels = [UInt8](repeating: 0, count: Int(info.width) * Int(info.height))
        try check(im2fit_mask(handle, &pixels, pixels.count, &info, infoSize))
        return Mask(width: Int(info.width), height: Int(info.height), pixels: pixels, userId: info.user_id,
                    sequence: info.sequence, timeNs: info.time_ns)
    }

    /// The reason why no person is found in an upright frame of the session's size: `millimetres`, row by row. Takes up to some
    /// tenths of a second and does not change the session.
    public func diagnose(millimetres: UnsafePointer<UInt16>, width: Int32, height: Int32) throws -> Diagnosis {
        var found = im2fit_diagnosis()
        try check(im2fit_diagnose(handle, millimetres, width, height, 0, &found, MemoryLayout<im2fit_diagnosis>.size))
        let text = withUnsafeBytes(of: &found.text) { String(decoding: $0.prefix { $0 != 0 }, as: UTF8.self) }
        return Diagnosis(code: FitSession.text(im2fit_diagnosis_name(found.code)), text: text, unitMm: found.unit_mm,
                         rotateDeg: found.rotate_deg)
    }

    /// Ends the stream and measures with the accepted frames.
    public func finish() throws -> Outcome {
        try check(im2fit_finish(handle))
        var result = try poll()
        guard result.measured == 1 else {
            return .notMeasured(state: FitSession.text(im2fit_state_name(result.state)),
                                guidance: FitSession.codes(result.guidance_seen))
        }
        let values = withUnsafeBytes(of: &result.measurements) { Array($0.bindMemory(to: im2fit_estimate.self)) }
        var measured: [String: Estimate] = [:]
        for (id, e) in values.enumerated() {
            measured[FitSession.text(im2fit_measurement_name(Int32(id)))] = Estimate(value: e.value, low: e.low, high: e.high)
        }
        return .measured(measured)
    }

    /// result.json (docs/result.md), measured or not.
    public func json() throws -> String {
        String(decoding: try bytes { im2fit_result_json(self.handle, $0?.assumingMemoryBound(to: CChar.self), $1, $2) },
               as: UTF8.self)
    }

    /// The person as the bytes of a .glb. Needs a measurement and a body.
    public func avatar() throws -> Data {
        Data(try bytes { im2fit_avatar(self.handle, Int32(IM2FIT_AVATAR_GLB.rawValue), $0, $1, $2) })
    }

    /// The person as .glb in clothes of the best sizes. `garments`: ids ("t_shirt"), innermost first; empty: trousers and a
    /// T-shirt.
    public func dressedAvatar(_ garments: [String] = []) throws -> Data {
        let names = garments.map { strdup($0) }
        defer { names.forEach { free($0) } }
        let worn = names.map { im2fit_worn(garment: UnsafePointer($0), size: nil) }
        return Data(try bytes { im2fit_dressed_avatar(self.handle, worn, worn.count, $0, $1, $2) })
    }

    /// How each size of a garment fits, small to large, and the index of the size to buy.
    public func fit(_ garment: String) throws -> (sizes: [SizeFit], best: Int) {
        let stride = MemoryLayout<im2fit_size_fit>.size
        var count = 0
        var best = 0
        let status = im2fit_garment_fit(handle, garment, nil, stride, 0, &count, nil)
        if status != Int32(IM2FIT_ERROR_TOO_SMALL.rawValue) { try check(status) }
        var fits = [im2fit_size_fit](repeating: im2fit_size_fit(), count: count)
        try check(im2fit_garment_fit(handle, garment, &fits, stride, count, &count, &best))
        return (fits.map { fit in
            let name = withUnsafeBytes(of: fit.name) { String(decoding: $0.prefix { $0 != 0 }, as: UTF8.self) }
            let places = withUnsafeBytes(of: fit.regions) {
                $0.bindMemory(to: im2fit_region_fit.self).prefix(Int(fit.region_count)).map { place in
                    PlaceFit(place: FitSession.text(place.name),
                             easeMm: Estimate(value: place.ease_mm, low: place.low_mm, high: place.high_mm),
                             verdict: FitSession.text(im2fit_fit_name(place.verdict)))
                }
            }
            return SizeFit(size: name, places: places)
        }, best)
    }

    /// The pose of the avatar in the latest frame; nil if no person is tracked. Needs a measurement. It changes after `next()`,
    /// when frames are processed again.
    public func rig() throws -> Rig? {
        var rig = im2fit_rig()
        let status = im2fit_live_rig(handle, &rig, MemoryLayout<im2fit_rig>.size)
        if status == Int32(IM2FIT_ERROR_NOT_FOUND.rawValue) { return nil }
        try check(status)
        let numbers = withUnsafeBytes(of: rig.rotations) { Array($0.bindMemory(to: Float.self)) }
        return Rig(root: SIMD3(rig.root_m.0, rig.root_m.1, rig.root_m.2), rotations: (0..<Int(IM2FIT_RIG_NODE_COUNT)).map {
            SIMD4(numbers[4 * $0], numbers[4 * $0 + 1], numbers[4 * $0 + 2], numbers[4 * $0 + 3])
        })
    }

    /// A description of the models that the session was opened with.
    public func modelInfo() throws -> ModelInfo {
        var models = im2fit_models()
        try check(im2fit_get_models(handle, &models, MemoryLayout<im2fit_models>.size))
        return ModelInfo(madeBy: FitSession.text(models.made_by), people: models.people, captures: models.captures,
                         trackerKey: models.tracker_key, hasBody: models.has_body != 0,
                         answersShape: models.answers_shape != 0, answersTurned: models.answers_turned != 0,
                         answersClothed: models.answers_clothed != 0, siteCorrected: models.site_corrected != 0)
    }

    /// Prepares for the next person. The measurement stays until the measured person has left.
    public func next() throws { try check(im2fit_next(handle)) }

    private func bytes(_ call: (UnsafeMutableRawPointer?, Int, UnsafeMutablePointer<Int>) -> Int32) throws -> [UInt8] {
        var size = 0
        let status = call(nil, 0, &size)
        if status != Int32(IM2FIT_ERROR_TOO_SMALL.rawValue) { try check(status) }
        var buffer = [UInt8](repeating: 0, count: size + 1)
        try check(buffer.withUnsafeMutableBytes { call($0.baseAddress, $0.count, &size) })
        return Array(buffer.prefix(size))
    }

    func poll() throws -> im2fit_result {
        var result = im2fit_result()
        try check(im2fit_poll(handle, &result, MemoryLayout<im2fit_result>.size))
        return result
    }

    func check(_ status: Int32) throws {
        guard status != 0 else { return }
        let own = FitSession.text(im2fit_last_error(handle))
        throw Im2fitError(status: status, description: own.isEmpty ? FitSession.text(im2fit_last_error(nil)) : own)
    }

    private static func codes(_ bits: UInt32) -> [String] {
        (0..<Int32(IM2FIT_GUIDANCE_COUNT)).filter { bits >> UInt32($0) & 1 == 1 }.map { text(im2fit_guidance_name($0)) }
    }

    static func text(_ name: UnsafePointer<CChar>?) -> String { name.map { String(cString: $0) } ?? "" }

    private static func withOptional<T>(_ text: String?, _ body: (UnsafePointer<CChar>?) -> T) -> T {
        text.map { $0.withCString { body($0) } } ?? body(nil)
    }
}
