// SPDX-License-Identifier: Apache-2.0
// Frames as Apple's frameworks deliver them: a pixel buffer, an ARFrame, an AVDepthData.
import CIm2fit
import Foundation

extension CameraModel {
    /// The upright camera of pictures that are delivered with these intrinsics and turned clockwise by `rotateDeg`.
    public init(delivered k: Intrinsics, width: Int32, height: Int32, rotateDeg: Int32) {
        let (w, h) = (Float(width), Float(height))
        switch rotateDeg {
        case 90: self.init(width: height, height: width, fx: k.fy, fy: k.fx, cx: h - 1 - k.cy, cy: k.cx)
        case 180: self.init(width: width, height: height, fx: k.fx, fy: k.fy, cx: w - 1 - k.cx, cy: h - 1 - k.cy)
        case 270: self.init(width: height, height: width, fx: k.fy, fy: k.fx, cx: k.cy, cy: w - 1 - k.cx)
        default: self.init(width: width, height: height, fx: k.fx, fy: k.fy, cx: k.cx, cy: k.cy)
        }
    }
}

#if canImport(CoreVideo)
import CoreVideo

extension FitSession {
    /// Processes a pixel buffer of `kCVPixelFormatType_DepthFloat32`. `confidence`: a buffer of the same size with one byte
    /// per sample; samples below `confidenceMin` count as no data. The rest is as in `push(metres:)`.
    public func push(_ depth: CVPixelBuffer, confidence: CVPixelBuffer? = nil, confidenceMin: Int32 = 1,
                     rotateDeg: Int32 = 0, timeNs: Int64 = 0, sequence: UInt64 = 0, down: SIMD3<Float> = .zero,
                     lens: Lens = Lens(), pose: CameraPose? = nil, intrinsics: Intrinsics? = nil) throws {
        let (width, height) = (CVPixelBufferGetWidth(depth), CVPixelBufferGetHeight(depth))
        guard CVPixelBufferGetPixelFormatType(depth) == kCVPixelFormatType_DepthFloat32 else {
            throw FitSession.refused("the depth is not kCVPixelFormatType_DepthFloat32")
        }
        if let sure = confidence {
            guard CVPixelBufferGetPixelFormatType(sure) == kCVPixelFormatType_OneComponent8,
                  CVPixelBufferGetWidth(sure) == width, CVPixelBufferGetHeight(sure) == height else {
                throw FitSession.refused("the confidence is not one byte for each sample of the depth")
            }
        }
        CVPixelBufferLockBaseAddress(depth, .readOnly)
        defer { CVPixelBufferUnlockBaseAddress(depth, .readOnly) }
        if let sure = confidence { CVPixelBufferLockBaseAddress(sure, .readOnly) }
        defer { if let sure = confidence { CVPixelBufferUnlockBaseAddress(sure, .readOnly) } }
        guard let samples = CVPixelBufferGetBaseAddress(depth) else {
            throw FitSession.refused("the depth has no memory")
        }
        let sure = confidence.flatMap { CVPixelBufferGetBaseAddress($0) }
        try push(metres: UnsafeRawPointer(samples).assumingMemoryBound(to: Float.self), width: Int32(width),
                 height: Int32(height), rowBytes: CVPixelBufferGetBytesPerRow(depth), rotateDeg: rotateDeg, timeNs: timeNs,
                 sequence: sequence, down: down, lens: lens, pose: pose,
                 confidence: sure.map { UnsafeRawPointer($0).assumingMemoryBound(to: UInt8.self) },
                 confidenceRowBytes: confidence.map { CVPixelBufferGetBytesPerRow($0) } ?? 0,
                 confidenceMin: sure == nil ? 0 : confidenceMin, intrinsics: intrinsics)
    }

    private static func refused(_ why: String) -> Im2fitError {
        Im2fitError(status: Int32(IM2FIT_ERROR_INVALID_ARGUMENT.rawValue), description: why)
    }
}
#endif

#if canImport(simd)
import simd

extension Intrinsics {
    /// Of a matrix for pictures of `fromWidth` pixels, scaled to pictures of `toWidth`: ARKit's and AVFoundation's matrices
    /// are those of the colour picture.
    public init(matrix k: matrix_float3x3, fromWidth: Int, toWidth: Int) {
        self = Intrinsics(fx: k.columns.0.x, fy: k.columns.1.y, cx: k.columns.2.x, cy: k.columns.2.y)
            .scaled(fromWidth: fromWidth, toWidth: toWidth)
    }
}
#endif

#if canImport(ARKit) && os(iOS)
import ARKit

extension Intrinsics {
    /// Of a frame's depth picture.
    public init(_ frame: ARFrame, depth: ARDepthData) {
        self.init(matrix: frame.camera.intrinsics, fromWidth: Int(frame.camera.imageResolution.width),
                  toWidth: CVPixelBufferGetWidth(depth.depthMap))
    }
}

extension CameraPose {
    /// Of a frame's camera.
    public init(_ frame: ARFrame) {
        let place = frame.camera.transform
        self.init(arkit: simd_quatf(place).vector,
                  metres: SIMD3(place.columns.3.x, place.columns.3.y, place.columns.3.z))
    }
}

extension FitSession {
    /// A session for frames like this one, held in portrait; nil: the frame has no depth yet. The configuration asks for it:
    /// `frameSemantics = .sceneDepth`.
    public convenience init?(_ frame: ARFrame, pack: URL, settings: FitSettings = FitSettings()) throws {
        guard let depth = frame.sceneDepth else { return nil }
        let camera = CameraModel(delivered: Intrinsics(frame, depth: depth),
                                 width: Int32(CVPixelBufferGetWidth(depth.depthMap)),
                                 height: Int32(CVPixelBufferGetHeight(depth.depthMap)), rotateDeg: 90)
        try self.init(camera: camera, pack: pack, settings: settings)
    }

    /// Processes a frame's `sceneDepth` with its confidence, pose and intrinsics; false: it has none. Not
    /// `smoothedSceneDepth`, which follows a person late. `confidenceMin`: 0 low, 1 medium, 2 high.
    @discardableResult
    public func push(_ frame: ARFrame, sequence: UInt64 = 0, confidenceMin: Int32 = 1) throws -> Bool {
        guard let depth = frame.sceneDepth else { return false }
        try push(depth.depthMap, confidence: depth.confidenceMap, confidenceMin: confidenceMin, rotateDeg: 90,
                 timeNs: Int64(frame.timestamp * 1e9), sequence: sequence, pose: CameraPose(frame),
                 intrinsics: Intrinsics(frame, depth: depth))
        return true
    }
}
#endif

#if canImport(AVFoundation) && !os(watchOS)
import AVFoundation

extension FitSession {
    /// Processes AVFoundation's depth, for example of `AVCaptureDepthDataOutput` with its filter switched off. Disparity is
    /// converted. Its intrinsics are used where it has them, else those of the session.
    public func push(_ data: AVDepthData, rotateDeg: Int32 = 0, timeNs: Int64 = 0, sequence: UInt64 = 0,
                     down: SIMD3<Float> = .zero, lens: Lens = Lens(), pose: CameraPose? = nil) throws {
        let metres = data.depthDataType == kCVPixelFormatType_DepthFloat32
            ? data : data.converting(toDepthDataType: kCVPixelFormatType_DepthFloat32)
        let map = metres.depthDataMap
        let k = metres.cameraCalibrationData.map {
            Intrinsics(matrix: $0.intrinsicMatrix, fromWidth: Int($0.intrinsicMatrixReferenceDimensions.width),
                       toWidth: CVPixelBufferGetWidth(map))
        }
        try push(map, rotateDeg: rotateDeg, timeNs: timeNs, sequence: sequence, down: down, lens: lens, pose: pose,
                 intrinsics: k)
    }
}
#endif
